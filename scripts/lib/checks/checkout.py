"""The files of a checkout that git tracks or would add, each read once. An archive without git history also works."""
import functools
import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import threading


class MissingTool(Exception):
    """Raised if a check needs a program that is not installed. The text is the program's name."""


class NotConfigured(Exception):
    """Raised if CMake cannot list the compile commands. The text is an offence."""


class Checkout:
    def __init__(self, root: pathlib.Path):
        self.root = root
        self.configuring = threading.Lock()  # because two checks configure the same folder

    @functools.cached_property
    def files(self):
        """The sorted paths of files relative to the root, without ignored and deleted files."""
        if self.has_history:
            listed = self.git("ls-files", "--cached", "--others", "--exclude-standard")
        else:
            with tempfile.TemporaryDirectory() as empty:
                subprocess.run(["git", "init", "--quiet", empty], check=True)
                listed = self.git("--git-dir", f"{empty}/.git", "--work-tree", str(self.root), "ls-files", "--others",
                                  "--exclude-standard")
        return sorted(name for name in set(listed.splitlines()) if (self.root / name).is_file())

    @functools.cached_property
    def has_history(self):
        return (self.root / ".git").exists()

    def named(self, *endings):
        return [name for name in self.files if name.endswith(endings)]

    @functools.cached_property
    def texts(self):
        """The files that people write, so no pictures, corpora or lock files."""
        return [name for name in self.files
                if not name.startswith(("tests/fuzz/corpus/", "common/cmake/example/assets/"))
                and not name.endswith(("package-lock.json", ".png", ".glb", ".blend", ".zip", ".svg", "LICENSE"))]

    @functools.lru_cache(maxsize=None)
    def read(self, name):
        return (self.root / name).read_text(encoding="utf-8", errors="replace")

    @functools.lru_cache(maxsize=None)
    def lines(self, name):
        return self.read(name).splitlines()

    def scripts(self, *interpreters):
        """Returns the files without an extension whose first line names one of the interpreters."""
        found = []
        for name in self.files:
            if "." in name.rsplit("/", 1)[-1]:
                continue
            with open(self.root / name, "rb") as file:
                first = file.readline(100)
            if first.startswith(b"#!") and any(word.encode() in first for word in interpreters):
                found.append(name)
        return found

    @functools.cached_property
    def base(self):
        """The commit to compare with: FRACTURE_CHECK_BASE, or the commit where the branch left main. On main, it is the second to last
        commit. "" if there is none."""
        base = os.environ.get("FRACTURE_CHECK_BASE", "")
        if base:
            return base
        head = self.git("rev-parse", "HEAD", check=False).strip()
        for main in ("origin/main", "main"):
            base = self.git("merge-base", "HEAD", main, check=False).strip()
            if base:
                break
        if not base or base == head:
            base = self.git("rev-parse", "--verify", "--quiet", "HEAD~1", check=False).strip() or head
        return base

    @functools.cached_property
    def prose_base(self):
        """The base for checks of comments and subjects. It is never older than the checks themselves, because they do not judge
        earlier text."""
        added = self.git("log", "--first-parent", "-m", "--diff-filter=A", "-1", "--format=%H", "--", "scripts/lib/checks/habits.py",
                         check=False).strip()
        if added and self.git("merge-base", self.base, added, check=False).strip() == self.git("rev-parse", self.base, check=False).strip():
            return added
        return self.base

    @functools.cached_property
    def changed(self):
        """The files that differ from the base, most recently changed first."""
        changed = self.git("ls-files", "--others", "--exclude-standard").splitlines()
        changed += self.git("diff", "--name-only", "HEAD").splitlines()
        changed += filter(None, self.git("log", "--name-only", "--format=", f"{self.base}..HEAD").splitlines())
        return list(dict.fromkeys(changed))

    @functools.cached_property
    def changed_lines(self):
        """{file: numbers of the lines that differ from prose_base}. In untracked files, all lines differ."""
        lines, name = {}, ""
        for line in self.git("diff", "--unified=0", "--find-renames", "--no-color", "--no-ext-diff", self.prose_base, check=False).splitlines():
            if line.startswith("+++ "):
                name = line[4:].removeprefix("b/")
            elif hunk := re.match(r"@@ -\S+ \+(\d+)(?:,(\d+))? @@", line):
                first, count = int(hunk[1]), int(hunk[2] or 1)
                lines.setdefault(name, set()).update(range(first, first + count))
        for name in self.git("ls-files", "--others", "--exclude-standard").splitlines():
            if (self.root / name).is_file():
                lines[name] = set(range(1, len(self.lines(name)) + 1))
        return lines

    @property
    def compile_commands(self):
        """{source file: its compile command}, without unity builds, whatever the build settings. Raises NotConfigured."""
        with self.configuring:
            return self._compile_commands

    @functools.cached_property
    def _compile_commands(self):
        # Include the benchmarks, because no test builds them.
        code, output = self.run("cmake", "--preset", "release", "-B", "build/tidy", "-DFRACTURE_UNITY=OFF", "-DFRACTURE_BUILD_BENCH=ON")
        if code != 0:
            raise NotConfigured(f"build/tidy:1: cannot be configured: {output[-300:]}")
        entries = json.loads((self.root / "build/tidy/compile_commands.json").read_text(encoding="utf-8"))
        commands = {}
        for entry in entries:  # a source in several targets compiles the same way in each
            commands.setdefault(entry["file"].removeprefix(f"{self.root}/"), entry["command"])
        return commands

    def git(self, *arguments, check=True):
        done = subprocess.run(["git", "-C", str(self.root), *arguments], capture_output=True, text=True)
        if check and done.returncode != 0:
            raise RuntimeError(f"git {' '.join(arguments)}: {done.stderr.strip()}")
        return done.stdout

    def run(self, *command):
        """Runs a program in the root. Returns its exit code and all output."""
        if not shutil.which(command[0]):
            raise MissingTool(command[0])
        done = subprocess.run(command, cwd=self.root, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        return done.returncode, done.stdout
