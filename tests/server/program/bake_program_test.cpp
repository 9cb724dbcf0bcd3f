// bake as its user runs it: pipes, misspelt words, refused paths, its messages and its exit codes.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <sstream>
#include <vector>

#include "common/digest/digest.hpp"
#include "common/pipeline/algorithm_version.hpp"
#include "server/bake/plan.hpp"
#include "server/service/failure_keeper.hpp"
#include "tests/server/support/bake_folder.hpp"
#include "tests/server/support/bake_program.hpp"
#include "tests/server/support/child_process.hpp"
#include "tests/server/support/relay.hpp"
#include "tests/server/support/server_process.hpp"

namespace fracture::test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

// -- links

TEST_F(BakeProgram, FollowsLinksToFoldersAndNamesLinksWithoutATarget) {
  ASSERT_EQ(
      shell("mkdir more linked && cp cube.off more/ && cp cube.off linked/ && ln -s ../more linked/more"), 0);
  EXPECT_EQ(shell("$f bake linked -o linked-out --sites 5 -q"), 0) << err;
  EXPECT_TRUE(fs::exists(folder / "linked-out/more/cube.off.glb"));
  ASSERT_EQ(shell("ln -s absent linked/props && ln -s absent.off linked/gone.off"), 0);
  EXPECT_EQ(shell("$f bake linked -o linked-out --sites 5 -q"), 1);
  EXPECT_THAT(err, AllOf(HasSubstr("cannot read linked/props: the link's target does not exist"),
                         HasSubstr("cannot read linked/gone.off: ")));
  EXPECT_EQ(shell("$f bake linked -o linked-out --explain"), 1);
  EXPECT_THAT(err, HasSubstr("cannot read linked/props: "));
}

// -- inspect

TEST_F(BakeProgram, InspectPrintsALineForEachMeshAndASummaryByCause) {
  EXPECT_EQ(shell("$f inspect in cube.off tub.off"), 3) << err;
  EXPECT_THAT(
      out, AllOf(HasSubstr("cube.off: closed; 1 x 1 x 1 m; 1 part; no overlaps; drops nothing\n"),
                 HasSubstr("in/box2.obj: closed; 2 x 1 x 1 m; 1 part; no overlaps; drops nothing\n"),
                 HasSubstr("tub.off: repaired; 1 x 1 x 1 m; 1 part; no overlaps; drops nothing; 1 choice\n"),
                 HasSubstr("in/poison/sheet.obj: refused: mesh-not-closed: ")));
  EXPECT_THAT(out, HasSubstr("6 files: 4 closed, 1 repaired, 1 refused\n"
                             "  refused: mesh-not-closed: 1 (in/poison/sheet.obj)\n"
                             "  repaired: open edges: 1 (tub.off)\n"
                             "  offers: lid: 1 (tub.off)\n"));
  EXPECT_EQ(shell("$f inspect in/gltf cube.off"), 0) << err;
  EXPECT_EQ(shell("$f inspect '*.off' --json"), 5) << err;
  std::vector<json> lines;
  std::istringstream text(out);
  for (std::string line; std::getline(text, line);) lines.push_back(json::parse(line));
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[0].at("input"), "cube.off");
  EXPECT_EQ(lines[0].at("size"), json({1, 1, 1}));
  EXPECT_EQ(lines[1].at("verdict"), "repaired");
  EXPECT_EQ(lines[2].at("summary").at("files"), 2);
  EXPECT_EQ(shell("mkdir some && cp cube.off some/ && ln -s absent some/props && $f inspect some"), 1);
  EXPECT_THAT(err, HasSubstr("cannot read some/props: the link's target does not exist"));
  EXPECT_THAT(out, HasSubstr("2 files: 1 closed, 1 unreadable\n"));
  EXPECT_EQ(shell("$f inspect cube.off -"), 2);
  EXPECT_EQ(shell("mkdir none && $f inspect none"), 2);
  EXPECT_THAT(err, HasSubstr("No mesh was found in 'none'."));
}

// -- pipes

TEST_F(BakeProgram, ReadsStandardInputAndWritesStandardOutput) {
  ASSERT_EQ(shell("$f bake cube.off -o file.glb --sites 20 -q"), 0) << err;
  const std::string file = bytes("file.glb");
  ASSERT_THAT(file, StartsWith("glTF"));
  EXPECT_EQ(shell("$f bake - -o - --sites 20 < cube.off > piped.glb"), 0) << err;
  EXPECT_EQ(bytes("piped.glb"), file) << "the bytes and no words";
  EXPECT_THAT(err, HasSubstr("standard output: 20 fragments"));
  EXPECT_EQ(shell("cat in/box1.obj | $f bake - --format obj -o - --sites 20 | cat > piped.glb"), 0) << err;
  EXPECT_EQ(shell("$f bake in/box1.obj -o - --sites 20 -q > direct.glb"), 0);
  EXPECT_EQ(err, "");
  EXPECT_EQ(bytes("piped.glb"), bytes("direct.glb"));
  EXPECT_EQ(shell("$f bake - -o out/x.gltf --sites 20 < cube.off"), 0) << err;
  EXPECT_TRUE(json::accept(bytes("out/x.gltf")));
  EXPECT_FALSE(fs::exists(folder / "-"));
}

TEST_F(BakeProgram, APipeThatSaysTooLittleIsRefusedAndOneThatIsClosedIsAnError) {
  EXPECT_EQ(shell("$f bake - -o x.glb < in/box1.obj"), 3);
  EXPECT_THAT(err, AllOf(HasSubstr("unknown-format"), HasSubstr("--format")));
  EXPECT_EQ(shell("$f bake - -o x.glb"), 3);
  EXPECT_THAT(err, HasSubstr("0 bytes"));
  EXPECT_EQ(shell("$f bake in/poison/sheet.obj -o - > x.glb"), 3);
  EXPECT_EQ(bytes("x.glb"), "");
  EXPECT_EQ(shell("mkfifo pipe; exec 8<>pipe 9>pipe; exec 8<&-; $f bake cube.off -o - -q >&9"), 1) << err;
  EXPECT_THAT(err, HasSubstr("cannot write to standard output"));
}

TEST_F(BakeProgram, StandardOutputThatIsATerminalIsRefused) {
  const int terminal = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  ASSERT_GE(terminal, 0);
  ASSERT_EQ(::grantpt(terminal), 0);
  ASSERT_EQ(::unlockpt(terminal), 0);
  const std::string name = ::ptsname(terminal);
  EXPECT_EQ(shell("$f bake cube.off -o - > " + name), 2);
  EXPECT_THAT(err, HasSubstr("terminal"));
  ::close(terminal);
}

TEST_F(BakeProgram, ASignalEndsTheWaitForAPipe) {
  // The shell holds both ends of the pipe. The fourth hexadecimal digit from the right of SigCgt contains bit
  // 14, SIGTERM; the digits listed here mean that the program catches it.
  const std::string caught =
      "for k in $(seq 6000); do grep -Eq 'SigCgt:.*[4567cdef][0-9a-f]{3}$' /proc/$!/status && break; "
      "sleep 0.01; done; ";
  // The additional tenth of a second is for the write that blocks.
  const std::string written =
      "for k in $(seq 6000); do grep -q encode .err && break; sleep 0.01; done; sleep 0.1; ";
  const std::string stop = "kill -TERM $!; wait $!";
  EXPECT_EQ(shell("mkfifo in.pipe; exec 8<>in.pipe; \"$f\" bake - -o x.glb <in.pipe & " + caught + stop), 130)
      << err;
  EXPECT_EQ(
      shell("mkfifo out.pipe; exec 8<>out.pipe; \"$f\" bake cube.off -o - >out.pipe & " + written + stop),
      130)
      << "nobody reads: " << err;
  EXPECT_FALSE(fs::exists(folder / "x.glb"));
}

// -- nothing is lost

TEST_F(BakeProgram, RefusesWhatItWouldLoseBeforeAnythingIsBaked) {
  ASSERT_EQ(shell("$f bake cube.off -o cube.glb -q"), 0) << err;
  const std::string mesh = bytes("cube.glb"), source = bytes("cube.off");
  const std::size_t before = files();
  fs::create_hard_link(folder / "cube.glb", folder / "hard.glb");
  fs::create_symlink("cube.glb", folder / "soft.glb");
  // Pipes and links replace devices, because a failing test that runs as root would damage real ones.
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  fs::create_symlink("/dev/stdout", folder / "descriptor");
  for (const std::string command :
       {"$f bake cube.off -o cube.off", "$f bake cube.off -o x.off", "$f bake cube.glb -o cube.glb",
        "$f bake cube.glb -o ./in/../cube.glb", "$f bake cube.glb -o hard.glb",
        "$f bake cube.glb -o soft.glb", "$f bake soft.glb -o cube.glb", "$f bake cube.off -o pipe",
        "$f bake cube.off -o descriptor", "$f bake cube.off -o x.glb --report cube.off",
        "$f bake cube.off -o x.glb --depfile cube.off", "$f bake in -o cube.glb", "$f bake in -o new.glb",
        "echo '{\"input\": \"cube.glb\", \"output\": \"in\"}' > .m; $f bake --manifest .m",
        "echo '{\"input\": \"cube.glb\", \"output\": \"cube.glb\"}' > .m; $f bake --manifest .m"}) {
    EXPECT_EQ(shell(command), 2) << command << ": " << err;
    EXPECT_THAT(err, StartsWith("fracture-server bake: ")) << command;
  }
  EXPECT_EQ(bytes("cube.glb"), mesh);
  EXPECT_EQ(bytes("hard.glb"), mesh);
  EXPECT_EQ(bytes("cube.off"), source);
  EXPECT_TRUE(fs::is_symlink(folder / "soft.glb"));
  EXPECT_TRUE(fs::is_symlink(folder / "descriptor"));
  EXPECT_TRUE(fs::is_fifo(folder / "pipe"));
  EXPECT_EQ(files(), before + 1) << "the hard link, and nothing else was made";
}

TEST_F(BakeProgram, EveryWrongLineOfAManifestIsNamedAndNothingIsMade) {
  folder.write(".m", R"({"input": "cube.off", "output": "good.glb", "parameters": {"sites": 5}}
{"input": "cube.off", "output": "b.glb", "parameters": {"sitess": 5}}
nonsense
{"input": "cube.off", "output": "d.glb", "parameters": {"of": "/fractures/sha256:)" +
                         std::string(64, '0') + R"("}}
)");
  EXPECT_EQ(shell("$f bake --manifest .m"), 2);
  EXPECT_THAT(err, AllOf(StartsWith("fracture-server bake: Line 2 of '.m': 'sitess' is not a parameter"),
                         HasSubstr("\nLine 3 of '.m': it is not a JSON object"),
                         HasSubstr("\nLine 4 of '.m': bake keeps no answers, so 'of' cannot refer to one.")));
  EXPECT_EQ(out, "");
  EXPECT_FALSE(fs::exists(folder / "good.glb"));
  EXPECT_FALSE(fs::exists(folder / ".m.report"));
}

TEST_F(BakeProgram, AFolderThatCannotBeWrittenToIsFoundBeforeAnythingIsMade) {
  folder.write("file", "no folder");
  folder.write(".m", R"({"input": "cube.off", "output": "good.glb", "parameters": {"sites": 5}}
{"input": "cube.off", "output": "file/bad.glb", "parameters": {"sites": 5}}
)");
  EXPECT_EQ(shell("$f bake --manifest .m"), 1);
  EXPECT_THAT(
      err, HasSubstr("cannot write file/bad.glb: the folder 'file' cannot be written to: Not a directory"));
  EXPECT_EQ(out, "") << "there is nothing to sum up";
  EXPECT_FALSE(fs::exists(folder / "good.glb"));
  EXPECT_EQ(shell("$f bake cube.off -o file/new/x.glb --sites 5"), 1);
  EXPECT_THAT(err, AllOf(HasSubstr("'file/new' cannot be written to"), Not(HasSubstr("encode"))));
  for (const std::string bad : {"/proc/x", "file", "file/below"})
    for (const std::string option : {"--keep-failures ", "--dump-stages "}) {
      EXPECT_EQ(shell("$f bake cube.off -o x.glb --sites 5 " + option + bad), 1) << option << bad;
      EXPECT_THAT(
          err, AllOf(HasSubstr("the folder '" + bad + "' cannot be written to"), Not(HasSubstr("encode"))));
      EXPECT_FALSE(fs::exists(folder / "x.glb"));
    }
  EXPECT_EQ(shell("$f bake in -o file/out --sites 5"), 1);
  EXPECT_THAT(err, HasSubstr("'file/out' cannot be written to"));
}

TEST_F(BakeProgram, MissingInputsOfAManifestAreNamedFirstAndTheOthersAreMade) {
  folder.write(".m", R"({"input": "absent.off", "output": "a.glb"}
{"input": "cube.off", "output": "good.glb", "parameters": {"sites": 5}}

{"input": "absent.off", "output": "b.glb"}
{"input": "in", "output": "c.glb"}
)");
  EXPECT_EQ(shell("$f bake --manifest .m -q -j 1"), 1);
  EXPECT_THAT(err,
              StartsWith("fracture-server bake: Lines 1, 4 of '.m': warning: cannot read absent.off: No such "
                         "file or directory.\nLine 5 of '.m': warning: cannot read in: Is a directory.\n"));
  EXPECT_TRUE(fs::exists(folder / "good.glb"));
  EXPECT_FALSE(fs::exists(folder / "a.glb"));
  EXPECT_EQ(shell("$f bake --manifest .m -q -j 1 --shard 1/4"), 0) << err;
  EXPECT_EQ(err, "") << "other shards name theirs";
}

TEST_F(BakeProgram, ResultsInTheFolderOfTheMeshesAreNotBakedAgain) {
  ASSERT_EQ(shell("$f bake in -o in --sites 5 --allow-refused 1 -q"), 0) << err;
  const auto first = outputs(folder / "in");
  ASSERT_EQ(shell("$f bake in -o in --sites 5 --allow-refused 1"), 0) << err;
  EXPECT_THAT(err, HasSubstr("skipped 3 results of earlier bakes"));
  EXPECT_THAT(out, AllOf(HasSubstr("4 jobs in "), HasSubstr("3 kept"), Not(HasSubstr("//"))));
  EXPECT_EQ(outputs(folder / "in"), first);
  fs::remove(folder / "in/bake.ndjson");
  ASSERT_EQ(shell("$f bake in -o elsewhere --sites 5 --allow-refused 1"), 0) << err;
  EXPECT_THAT(out, HasSubstr("3 made")) << "known by their content too";
  EXPECT_EQ(outputs(folder / "elsewhere").size(), 3u);
}

// -- messages

TEST_F(BakeProgram, WarnsInTheSameWordsForOneFileAndForMany) {
  const std::string far = " --sites 5 --keep-center 99,0,0 --keep-radius 1";
  ASSERT_EQ(shell("$f bake tub.off -o one.glb -q" + far), 0) << err;
  const std::string words = err;
  EXPECT_THAT(
      words,
      HasSubstr(
          "tub.off: warning: The region of 'keep_center' and 'keep_radius' contains no part of the mesh"));
  EXPECT_THAT(words, Not(HasSubstr(": note: "))) << "quiet";
  fs::create_directory(folder / "many");
  ASSERT_EQ(shell("$f bake tub.off -o many/ -q" + far), 0) << err;
  EXPECT_EQ(err, words);
  EXPECT_EQ(bytes("many/tub.off.glb"), bytes("one.glb"));
  EXPECT_EQ(json::parse(bytes("many/bake.ndjson")).at("warnings").size(),
            static_cast<std::size_t>(std::count(words.begin(), words.end(), '\n')));
  ASSERT_EQ(shell("$f bake tub.off -o one.glb --sites 5"), 0) << err;
  EXPECT_THAT(err, AllOf(HasSubstr("tub.off: note: "), Not(HasSubstr(": warning: "))));
}

TEST_F(BakeProgram, RefusesInTheSameWordsForOneFileAndForMany) {
  ASSERT_EQ(shell("$f bake in/poison/sheet.obj -o one.glb -q"), 3);
  const std::string words = err;
  EXPECT_THAT(words, HasSubstr("in/poison/sheet.obj: mesh-not-closed: "));
  ASSERT_EQ(shell("$f bake in/poison -o many -q"), 3);
  EXPECT_EQ(err, words);
  EXPECT_EQ(shell("$f bake in/poison/sheet.obj -o one.glb -q --allow-refused 1"), 0);
  EXPECT_FALSE(fs::exists(folder / "one.glb"));
}

TEST_F(BakeProgram, WritesAFormatByTheEndingForOneFileAndForMany) {
  std::string manifest;
  for (const char* name : {"a.glb", "a.GLTF", "a"})
    manifest += json{{"input", "cube.off"}, {"output", std::string("many/") + name}}.dump() + "\n";
  folder.write("m", manifest);
  ASSERT_EQ(shell("$f bake --manifest m -q"), 0) << err;
  for (const std::string name : {"a.glb", "a.GLTF", "a"}) {
    ASSERT_EQ(shell("$f bake cube.off -q -o one/" + name), 0) << err;
    EXPECT_EQ(bytes("many/" + name), bytes("one/" + name)) << name;
  }
  EXPECT_TRUE(json::accept(bytes("many/a.GLTF")));
  EXPECT_EQ(bytes("many/a"), bytes("many/a.glb"));
}

TEST_F(BakeProgram, ParametersMayBeWrittenWithDashes) {
  ASSERT_EQ(shell("$f bake cube.off -q -o a.glb --max_fragments 5 --interior_name Core"), 0) << err;
  ASSERT_EQ(shell("$f bake cube.off -q -o b.glb --max-fragments=5 --interior-name Core"), 0) << err;
  EXPECT_EQ(bytes("a.glb"), bytes("b.glb"));
  EXPECT_EQ(shell("$f bake cube.off -q -o c.glb --max-fragments=5 --max_fragments 6"), 2) << "given twice";
  ASSERT_EQ(shell("$f inspect tub.off --weld-tolerance=0.001"), 5) << err;
  ASSERT_EQ(shell("$f bake --help"), 0);
  EXPECT_THAT(out, AllOf(HasSubstr("--max-fragments"), Not(HasSubstr("--max_fragments"))));
}

TEST_F(BakeProgram, AWrongCommandLineIsAnsweredWithTheRequirementAndTheValue) {
  const std::pair<std::string, std::string> cases[] = {
      {"", "Give a command: serve, bake, inspect or health."},
      {"inspect", "inspect: Give a mesh file, a folder or a glob"},
      {"bake", "bake: Give mesh files, folders or globs, or a --manifest."},
      {"bake cube.off -o", "--output needs a value."},
      {"bake cube.off -o x.glb -j 5000", "must be a whole number from 0 to 1,024; it was '5000'"},
      {"bake cube.off -o x.glb --allow-refused -1",
       "must be a whole number from 0 to 1,000,000,000; it was '-1'"},
      {"bake cube.off -o x.glb --memory 1KiB", "must be from 1MiB to 1PiB, such as 64MiB; it was '1KiB'"},
      {"serve --port 1 --port 2", "--port is given more than once. Give it once."},
      {"serve --max-body 2GiB --max-bodies 1GiB", "max-body (2GiB) is over max-bodies (1GiB)"},
      {"serve --log-level loud", "must be trace, debug, info, warn, error or off"},
      {"serve --config absent.toml", "--config 'absent.toml' cannot be read: No such file or directory"},
      {"serve --config in", "--config 'in' cannot be read: Is a directory"},
      {"serve --farm-key-file in", "--farm-key-file 'in' cannot be read: Is a directory"}};
  for (const auto& [command, said] : cases) {
    EXPECT_EQ(shell("$f " + command), 2) << command;
    EXPECT_THAT(err, HasSubstr(said)) << command;
  }
}

TEST_F(BakeProgram, AMisspeltWordIsAnsweredWithTheNearest) {
  const struct {
    std::string command, said;
    int code;
  } cases[] = {
      {"bake cube.off -o x.glb --max-fragmnets 5",
       "there is no option --max-fragmnets; did you mean --max-fragments?", 2},
      {"bake cube.off -o x.glb --max_fragmnets=5",
       "there is no option --max_fragmnets; did you mean --max-fragments?", 2},
      {"bake cube.off -o x.glb --mainfest m", "did you mean --manifest?", 2},
      {"bake cube.off --ouput x.glb", "did you mean --output?", 2},
      {"bake cube.off -o x.glb --colour red", "there is no option --colour\n", 2},
      {"bake cube.off -o x.glb --pieces 5", "there is no option --pieces; did you mean --fragments?", 2},
      {"bake cube.off -o x.glb --insertion flip",
       "must be cavity or flips; it was 'flip'. Did you mean 'flips'?", 2},
      {"bake cube.off -o x.glb --material glas", "it was 'glas'. Did you mean 'glass'?", 3},
      {"serve --log-level wran", "(nearest: warn)", 2},
      {"serve --enable-format bled", "did you mean blend?", 2},
      {"inspect --thikness=5", "did you mean --thickness?", 2},
      {"serve --max-boddy 5", "did you mean --max-body?", 2},
      {"serve --max_body 5", "did you mean --max-body?", 2},
      {"serve --prot 5", "did you mean --port?", 2},
      {"health --redy", "did you mean --ready?", 2},
      {"bkae cube.off -o x.glb", "there is no command 'bkae'; did you mean bake?", 2},
      {"inpsect cube.off", "did you mean inspect?", 2},
      {"cube.off", "there is no command 'cube.off': there are serve, bake, inspect, health", 2},
      {"--verison", "did you mean --version?", 2},
      {"--sites 5 bake cube.off -o x.glb", "there is no option --sites before the command bake", 2},
  };
  for (const auto& c : cases) {
    EXPECT_EQ(shell("$f " + c.command), c.code) << c.command;
    EXPECT_THAT(err, HasSubstr(c.said)) << c.command;
    EXPECT_EQ(out, "") << c.command;
  }
  EXPECT_FALSE(fs::exists(folder / "x.glb"));
}

TEST_F(BakeProgram, TakesMemoryInBytesAndNothingElse) {
  EXPECT_EQ(shell("$f bake cube.off -o x.glb -q --memory 512MiB"), 0) << err;
  for (const char* wrong : {"5", "5GB", "-1", "lots", "1.5GiB"}) {
    EXPECT_EQ(shell("$f bake cube.off -o x.glb -q --memory=" + std::string(wrong)), 2) << wrong;
    EXPECT_THAT(err, AllOf(HasSubstr("--memory"), HasSubstr(wrong)));
  }
}

// -- kept failures

TEST_F(BakeProgram, TheCommandOfAKeptFailureReproducesTheAnswer) {
  const json parameters = {{"sites", 20},
                           {"pattern", "impact"},
                           {"impacts", {{0.5, 0.5, -0.25}}},
                           {"interior_name", "a 'core' of $5"},
                           {"gravity", {0, -3.5, 0}}};
  std::vector<RawParameter> given;
  for (const auto& [name, value] : parameters.items()) given.push_back({name, value, false});
  const Expected<RequestParameters> parsed = ParameterTable(100'000, FormatSet::all()).parse(given);
  ASSERT_TRUE(parsed) << parsed.error().detail;
  const std::string mesh = bytes("in/gltf/box.gltf"), buffer = bytes("in/gltf/box data/box.bin");
  FractureRequest request{std::as_bytes(std::span(mesh)), MeshFormat::kGltf, *parsed};
  request.files.push_back({"box data/box.bin", std::as_bytes(std::span(buffer))});
  FailureKeeper keeper({.folder = folder / "kept"});
  keeper.keep(request, {ErrorCode::kUnsound, "So it is said."}, nullptr, "the box.gltf");
  ASSERT_EQ(keeper.figures().kept, 1u);
  const std::string place = fs::directory_iterator(folder / "kept")->path();
  const std::string command = json::parse(read_file(place + "/request.json")).at("command");
  ASSERT_EQ(shell("PATH=\"$(dirname \"$f\"):$PATH\"; cd '" + place + "' && " + command), 0) << err;
  folder.write(
      "m", json{{"input", "in/gltf/box.gltf"}, {"output", "direct.glb"}, {"parameters", parameters}}.dump());
  ASSERT_EQ(shell("$f bake --manifest m -q"), 0) << err;
  EXPECT_EQ(read_file(place + "/fragments.glb"), bytes("direct.glb"));
}

}  // namespace
}  // namespace fracture::test
