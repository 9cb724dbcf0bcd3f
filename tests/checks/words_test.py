#!/usr/bin/env python3
"""Tests scripts/check words: names, writing habits in texts and in comments on changed lines, and the list of files
that may wait."""
import unittest

from planted import PlantedCheckout

NOT_YET = "scripts/lib/checks/not_yet.txt"
# Each habit, texts that have it, and similar texts that do not have it.
HABITS = (
    ("of-first",
     ("Of an aggregate, which has one for each cell.", "Each is noted once. Of several the first one."),
     ("Maximum number of hulls for a fragment.", "Of course it is exact.", "Of the 500 requests 3 failed.", "Of 65 answers 52 were hit.")),
    ("what-first",
     ("What the limits of size unite.", "It is read once. Where it ends is not known.", "Who waits for a loop stays awake.",
      "Whoever comes last is refused."),
     ("The pieces that the limits merge.", "What does it cost?", "Who may ask, and how often?", "Read what it says.",
      "What to do: ask again.", "Where possible, reuse it.", "What's new is in the list.")),
    ("what-noun",
     ("The sum of what is kept.", "It works with what the caller gave.", "More than what was asked.", "Room for what cannot be read."),
     ("The sum of the kept sizes.", "It depends on what the client sends.", "Say what it does.", "They break only what is near.",
      "It is the same regardless of what is cached.")),
    ("where-if",
     ("Where there is none it is made.", "Empty where none was given.", "Closed where that is possible.", "False where nobody answers.",
      "0 where it is not known."),
     ("Empty if none was given.", "The folder where the file is.", "It goes on where it was.", "The place where no two cells meet.",
      "The reader learns where that is.")),
    ("is-no",
     ("It is no program that can be started.", "Such cells are no partition.", "It was no folder."),
     ("It is not an executable program.", "There is no limit.", "It is no longer open.", "There must be no gap.",
      "The edge is no farther than the site.", "It is no shorter.",
      "It is no more than a hint.")),
    ("beside",
     ("The file beside it.", "Beside hits a hundredth of that."),
     ("The file next to it.", "With hits, a hundredth of that.", "Besides, it is fast.")),
    ("who",
     ("It is kept for who asks.", "A thread who waits stays awake.", "It ends later: who comes first is served."),
     ("It is kept for the client that asks.", "A thread that waits stays awake.", "Users who wait see a bar.", "Learn who asks.")),
    ("for-because",
     ("It is refused, for a shorter one would end in the older.", "It is kept, for it is needed again.", "Ignored, for a cache may miss."),
     ("It is refused because a shorter one would end later.", "It is kept for its owner.", "Ask again, for example with fewer sites.",
      "A limit, for a mesh that is closed.", "It waits, for the vertices it is too early.")),
    ("stands",
     ("The proof stands in the paper.", "The limits stand below.", "The name stands there."),
     ("The proof is in the paper.", "The name stands for its value.", "Nothing stands in the way.", "It stands in for the renderer.",
      "The vase stands on the ground.")),
    ("lies",
     ("The picture lies in the folder.", "It lies in memory.", "The key lies on the disk."),
     ("The picture is in the folder.", "The point lies in the cell.", "The site lies on the plane.")),
    ("told",
     ("Joints are told from bricks by their width.", "Which is which cannot be told.", "Every failure is told here."),
     ("Joints are distinguished from bricks.", "The server was told to stop.", "Hulls that are told apart.")),
    ("of-own",
     ("It is read with an own reader.", "It gets a mesh of its own.", "Parts with grains of their own."),
     ("It is read with our own reader.", "It gets its own mesh.", "It bends under the load of its own weight.", "The order of their owners.")),
    ("several",
     ("Pieces of several parts become one fragment.",),
     ("Pieces of different parts become one fragment.", "A mesh of several parts.")),
    ("another-than",
     ("It has another number of vertices than the shape.", "It has another size than its source."),
     ("It has a different number of vertices from the shape.", "Choose another number.", "Use another format rather than this one.")),
    ("by-itself",
     ("Each side was closed by itself.", "Changes that it does not make it by itself."),
     ("Each side was closed separately.", "The program ended by itself.")),
    ("meant",
     ("If the size cannot be meant, it warns.",),
     ("If the size is implausible, it warns.", "If a solid is meant, delete it.")),
    ("stands-for",
     ("A node stands for all nodes below it.", "The radius stands with the hits."),
     ("A node matches all nodes below it.", "The name stands for its value.", "A proxy stands for many clients.")),
    ("said",
     ("All mistakes are said at once.", "It is said on standard error."),
     ("All mistakes are reported at once.", "Meshes that are said to be closed.", "It says so.")),
)
LONG = "The " + "very " * 38 + "long sentence."


class Words(PlantedCheckout):
    def expect_found_here(self, name, text, *said):
        self.plant(name, text)
        self.expect_found("words", *said)

    def test_one_thing_has_one_name(self):
        self.expect_clean("words")
        self.expect_found_here("common/base/vec.hpp", "#pragma once\n// The tetrahedrons.\nint twice(int x);\n",
                               "common/base/vec.hpp:2: 'tetrahedrons' -> tetrahedra")

    def test_finds_curl_lines_that_take_an_error_for_an_answer(self):
        good = "    curl --fail-with-body -T a.glb http://server/fracture -o b.glb\n    curl --fail http://server/a.glb | program\n"
        self.plant("README.md", good)
        self.expect_clean("words")
        for bad in ("curl -T a.glb http://server/fracture -o b.glb", "curl http://server/a.glb | program", "curl 'http://server/a.glb' > a.glb",
                    'curl $options "http://server/a.glb" -O'):
            self.plant("README.md", f"{good}    {bad}\n")
            self.expect_found("words", "README.md:3: 'curl ", "-> curl --fail-with-body")

    def test_every_habit_is_found_and_its_neighbours_are_not(self):
        good = [text for _, _, texts in HABITS for text in texts]
        self.plant("README.md", "# Title\n\n" + "\n\n".join(good) + "\n")
        self.expect_clean("words")
        bad = [(habit, text) for habit, texts, _ in HABITS for text in texts]
        self.plant("README.md", "# Title\n\n" + "\n\n".join(text for _, text in bad) + "\n")
        status, said = self.check("words")
        self.assertEqual(status, 1)
        for k, (habit, text) in enumerate(bad):
            with self.subTest(habit, text=text):
                self.assertIn(f"README.md:{3 + 2 * k}: {habit}: '", said)

    def test_headings_name_their_subject(self):
        self.plant("README.md", "# Guarantees\n\n## What to do next\n\n## How it works\n\n## What does it cost?\n")
        self.expect_clean("words")
        self.expect_found_here("README.md", "# Title\n\n## What holds\n", "README.md:3: heading: 'What holds'")
        self.expect_found_here("README.md", "# Nothing comes from nowhere\n", "README.md:1: heading: ")

    def test_sentences_have_40_words_at_most(self):
        self.expect_found_here("README.md", f"# Title\n\n{LONG}\n", "README.md:3: long: 'The very very", "it has 41 words")
        self.plant("README.md", "# Title\n\n" + LONG.replace("very ", "", 1) + "\n\n- " + "word " * 30 + "\n- " + "word " * 30 + "\n")
        self.expect_clean("words")
        self.plant("README.md", "# Title\n\nFormats: " + ", ".join(["obj"] * 50) + ".\n\n`" + "code " * 50 + "`\n\n    " + LONG + "\n")
        self.expect_clean("words")

    def test_rows_of_tables_have_200_characters_at_most(self):
        head = "# Title\n\n| a | b |\n|---|---|\n"
        self.plant("README.md", head + "| short | " + "x" * 188 + " |\n")
        self.expect_clean("words")
        self.expect_found_here("README.md", head + "| short | " + "x" * 189 + " |\n", "README.md:5: row: 201 characters")

    def test_texts_for_users_are_found_wherever_they_are(self):
        for name, text, line in (
                ("server/cli.cpp", 'const char* text = "the file "\n    "is no program that can be started";\n', 2),
                ("server/problems.def", 'PROBLEM(kX, 404, "Where none is given the first one is used.")\n', 1),
                ("client/page/words.ts", "export const words = { hint: 'The figures stand under all parameters.' };\n", 1),
                ("client/page/index.html", "<p>\nIt lies in the folder of the page.\n</p>\n", 2),
                ("client/python/pack.py", 'def f():\n    """Makes it.\n\n    Of a script: waits."""\n', 4),
                ("client/typescript/src/glb.ts", "/** What this package reads. */\n", 1),
                ("proto/openapi.yaml", "paths:\n  /a:\n    description: What the page loads\n", 3),
                ("proto/a.schema.json", '{\n"description": "What became of one mesh."\n}\n', 2),
                ("scripts/run", "#!/usr/bin/env bash\n# Runs the server.\n#\n# What is missing is installed.\necho \"$1\"\n", 4)):
            before = (self.root / name).read_text() if (self.root / name).exists() else None
            self.plant(name, text)
            self.commit("words: plant what users read")
            self.plant("tests/b_test.cpp", f"// {name}\n")
            self.commit("words: change something else")  # so that none of its lines counts as changed
            with self.subTest(name):
                self.expect_found("words", f"{name}:{line}: ")
            (self.root / name).unlink()
            if before:
                self.plant(name, before)
        self.expect_clean("words")

    def test_names_keys_and_strings_of_tests_are_no_texts(self):
        self.plant("server/cli.cpp", 'const char* a = "Of-a";\nconst char* b = "where none";\n')
        self.plant("tests/a_test.cpp", 'const char* a = "the file is no program that can be started";\n')
        self.plant("README.md", "# Title\n\n`What it is.`\n\n```\nWhat it is said to be is said.\n```\n")
        self.expect_clean("words")

    def test_comments_count_on_changed_lines_and_with_all(self):
        old = "#pragma once\n// What the caller gave.\nint twice(int x);\n"
        self.plant("common/base/vec.hpp", old)
        self.commit("base: plant an old comment")
        self.plant("README.md", "# Title\n")
        self.commit("docs: change something else")
        self.expect_clean("words")
        status, said = self.check("--all", "words")
        self.assertEqual(status, 1)
        self.assertIn("common/base/vec.hpp:2: what-first: 'What the caller gave.'", said)
        self.plant("common/base/vec.hpp", old + "\n// Of the sum: twice.\nint four();\n")
        status, said = self.check("words")
        self.assertEqual(status, 1)
        self.assertIn("common/base/vec.hpp:5: of-first:", said)
        self.assertNotIn("vec.hpp:2:", said)
        self.plant("common/base/vec.hpp", old)
        self.plant("server/new.py", "x = 1  # what it holds\n# It is no list.\n")
        self.expect_found("words", "server/new.py:2: is-no:")  # git does not know the file yet

    def test_a_sentence_counts_when_one_of_its_lines_changed(self):
        self.plant("common/base/vec.hpp", "// The\n" + "// very very very very very very very very\n" * 5 + "// long sentence.\n")
        self.commit("base: plant a long sentence")
        self.plant("README.md", "# Title\n")
        self.commit("docs: change something else")
        self.expect_clean("words")
        self.plant("common/base/vec.hpp", "// The\n" + "// very very very very very very very very\n" * 5 + "// longer and longer sentence.\n")
        self.expect_found("words", "common/base/vec.hpp:1: long:")

    def test_files_may_wait_until_they_are_clean(self):
        self.plant(NOT_YET, "# why\nREADME.md\n")
        self.plant("README.md", "# Title\n\nIt is no list.\n")
        status, said = self.check("words")
        self.assertEqual(status, 0, said)
        self.assertIn("1 files are not checked for writing habits", said)
        self.expect_found_here("README.md", "# Title\n", f"{NOT_YET}:2: README.md -> its texts are clean: remove it from the list")
        self.plant("server/README.md", "# What holds\n")
        self.plant(NOT_YET, "# why\nREADME.md\nserver/README.md\n")
        self.assertEqual(self.check("--fix", "words")[0], 0)
        self.assertEqual((self.root / NOT_YET).read_text(), "# why\nserver/README.md\n")
        self.plant(NOT_YET, "# why\nREADME.md\nserver/README.md\n")
        (self.root / "README.md").unlink()
        self.expect_found("words", f"{NOT_YET}:2: README.md -> the file does not exist")


if __name__ == "__main__":
    unittest.main(verbosity=2)
