"""Each header and each source file must compile on its own, so it must include what it uses.

Builds can hide missing includes: a unity build compiles several sources as one, and a header is usually read after
others. This check compiles each source separately, without precompiled headers. If a header is the first include of a source,
compiling the source also checks the header. Every other header is compiled separately.

Without --all, the check compiles files that changed on the branch and files that include them, nearest first. A file is not
compiled again until its text, an included file's text or its command changes.
"""
import concurrent.futures
import functools
import hashlib
import os
import posixpath
import re
import shlex
import subprocess
import tempfile
import threading

from .checkout import NotConfigured

CPP = (".cpp", ".hpp")
INCLUDE = re.compile(r'^\s*#\s*include\s+(?:"([^"]+)"|<[^>]+>)', re.MULTILINE)
ERROR = re.compile(r"^(.+?):(\d+):(?:\d+:)? (?:fatal )?error: (.*)$", re.MULTILINE)

# Maximum number of affected files compiled without --all, at about four seconds each on one core.
MOST_COMPILED = 40
# Time limit in seconds for one file, even on a busy machine.
LIMIT = 600
# Processor seconds that the compiler may take to read one file. The slowest file takes six on an idle machine and ten on a busy one.
MOST_TO_READ = 20


class IncludeGraph:
    """The include graph of the checkout's files."""

    def __init__(self, checkout):
        self.checkout, self.names = checkout, checkout.named(*CPP)
        self.known = set(checkout.files)
        self.users = {}
        for name in self.names:
            for included in self.included_by(name):
                self.users.setdefault(included, []).append(name)

    @functools.lru_cache(maxsize=None)
    def resolved(self, name):
        """Returns a file's includes in textual order: a path for a file of the checkout, None for any other file."""
        found = []
        for match in INCLUDE.finditer(self.checkout.read(name)):
            near = posixpath.normpath(posixpath.join(posixpath.dirname(name), match[1] or ""))
            found.append(next((path for path in (near, match[1]) if path in self.known), None))
        return found

    def included_by(self, name):
        return [path for path in self.resolved(name) if path]

    def reached(self, names, following):
        """Returns the names and everything reachable from them through `following`, nearest first."""
        found, level = dict.fromkeys(names), list(names)
        while level:
            level = list(dict.fromkeys(path for name in level for path in following(name) if path not in found))
            found.update(dict.fromkeys(level))
        return list(found)

    def read_by(self, name):
        return self.reached([name], self.included_by)

    def affected_by(self, names):
        return self.reached(names, lambda name: self.users.get(name, []))


def compiler_runs(graph, commands, wanted):
    """Returns {file to compile: command} for the wanted files. Headers that no compiled source includes get their own entries."""
    first = {}  # header: a source that includes it before anything else; if possible, the header's own source
    for source in commands:
        header = next(iter(graph.resolved(source)), None) if source in graph.known else None
        if header and (header not in first or source == header.removesuffix(".hpp") + ".cpp"):
            first[header] = source
    runs, unused = {}, []
    for name in wanted:
        name = first.get(name, name)
        if name in commands:
            runs[name] = commands[name]
        elif name.endswith(".hpp"):
            source = next((user for user in graph.affected_by([name]) if user in commands), None)
            if source:
                runs[name] = commands[source]
            else:
                unused.append(name)
    return runs, unused


def words_of(command):
    """Returns the arguments of a compile command without input, output and precompiled header."""
    words, kept = shlex.split(command), []
    if posixpath.basename(words[0]) == "ccache":
        words = words[1:]
    skip = False
    for word in words[:-1]:
        if skip or word in ("-c", "-Winvalid-pch"):
            skip = False
        elif word in ("-o", "-include", "-MF", "-MT"):
            skip = True
        else:
            kept.append(word)
    return [*kept, "-w", "-fsyntax-only", "-x", "c++", "-"]


def run_timed(words, folder, text):
    """Runs a program with this text as input. Returns (exit code, output, processor seconds). Raises subprocess.TimeoutExpired."""
    with tempfile.TemporaryFile("w+") as given, tempfile.TemporaryFile("w+") as said:
        given.write(text)
        given.seek(0)
        process = subprocess.Popen(words, cwd=folder, stdin=given, stdout=said, stderr=subprocess.STDOUT, env={**os.environ, "LC_ALL": "C"})
        too_long = threading.Timer(LIMIT, process.kill)
        too_long.start()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if not too_long.is_alive():
            raise subprocess.TimeoutExpired(words, LIMIT)
        too_long.cancel()
        said.seek(0)
        return process.returncode, said.read(), usage.ru_utime + usage.ru_stime


def compile_alone(checkout, name, words):
    """Compiles one file. Returns an offence (the compiler's first error, or that it took too long); None if there is none."""
    try:
        code, output, seconds = run_timed(words, checkout.root, f'#include "{checkout.root / name}"\n')
    except subprocess.TimeoutExpired:
        return f"{name}:1: does not compile on its own within {LIMIT} s"
    if code == 0:
        if seconds <= MOST_TO_READ:
            return None
        return f"{name}:1: the compiler needs {seconds:.0f} s to read it; at most {MOST_TO_READ} are allowed: include less, or split the file"
    error = ERROR.search(output)
    if not error:
        return f"{name}:1: does not compile alone: {output[-300:]}"
    return f"{error[1].removeprefix(f'{checkout.root}/')}:{error[2]}: {error[3]} ({name} does not compile alone)"


def check(checkout, every):
    graph = IncludeGraph(checkout)
    if not every and not checkout.has_history:
        print("check includes: skipped, because without git history the changed files are unknown; --all compiles all files", flush=True)
        return []
    wanted = graph.names if every else graph.affected_by([name for name in checkout.changed if name in graph.known])
    wanted = [name for name in wanted if name.endswith(CPP) and not name.startswith("common/cmake/")]  # a separate project
    if not wanted:
        return []
    try:
        commands = checkout.compile_commands
    except NotConfigured as failed:
        return [str(failed)]
    runs, unused = compiler_runs(graph, commands, wanted)
    offences = [f"{name}:1: no compiled source includes it" for name in unused]

    @functools.lru_cache(maxsize=None)
    def version_of(compiler):
        return checkout.run(compiler, "--version")[1]

    def key_of(name, words):
        digest = hashlib.sha256(repr((version_of(words[0]), words)).encode())
        for path in graph.read_by(name):
            digest.update(repr((path, checkout.read(path))).encode())
        return digest.hexdigest()

    memory = checkout.root / "build/tidy/compiled_alone.txt"
    known = set(memory.read_text().split()) if memory.exists() else set()
    left = []
    for name, command in runs.items():
        words = words_of(command)
        if (key := key_of(name, words)) not in known:
            left.append((name, words, key))
    if not every and len(left) > MOST_COMPILED:
        print(f"check includes: compiling the nearest {MOST_COMPILED} of {len(left)} affected files; --all compiles all files", flush=True)
        left = left[:MOST_COMPILED]

    def run(unit):
        name, words, key = unit
        error = compile_alone(checkout, name, words)
        if not error:
            with open(memory, "a") as file:
                file.write(key + "\n")
        return error

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        return offences + list(dict.fromkeys(filter(None, pool.map(run, left))))
