"""Checks that run other programs: clang-format, clang-tidy, shellcheck, flake8, codespell."""
import concurrent.futures
import os
import pathlib
import re

from .checkout import NotConfigured

CPP = (".cpp", ".hpp")
SPELLING = pathlib.Path(__file__).with_name("spelling.txt")


def check_format(checkout, _all):
    files = checkout.named(*CPP)
    if not files:
        return []
    _, output = checkout.run("clang-format", "--dry-run", *files)
    wrong = dict.fromkeys(line.split(":")[0] for line in output.splitlines() if "[-Wclang-format-violations]" in line)
    return [f"{name}:1: is not formatted as .clang-format requires" for name in wrong]


def fix_format(checkout):
    files = checkout.named(*CPP)
    if files:
        checkout.run("clang-format", "-i", *files)


def check_shell(checkout, _all):
    files = checkout.named(".sh") + checkout.scripts("bash", "/sh")
    if not files:
        return []
    _, output = checkout.run("shellcheck", "--severity=warning", "--format=gcc", *files)
    return output.splitlines()


def check_python(checkout, _all):
    files = checkout.named(".py") + checkout.scripts("python")
    if not files:
        return []
    _, output = checkout.run("flake8", *files)
    return [line.removeprefix("./") for line in output.splitlines()]

# Maximum number of files that clang-tidy checks without --all, at about five seconds each on one core.
MOST_TIDIED = 40


def codespell(checkout, *options):
    # Constants (kName) are not English words, so they are left out.
    return checkout.run("codespell", "--ignore-words", str(SPELLING), "--ignore-regex", r"\bk[A-Z]\w*", *options,
                        *(name for name in checkout.texts if not name.startswith("tests/checks/")))[1].splitlines()


def check_spelling(checkout, _all):
    return codespell(checkout)


def fix_spelling(checkout):
    codespell(checkout, "--write-changes")


def tidied_files(checkout, every):
    """Returns the source files to check. A header is checked through its own source file, or through the first file that includes
    it. If a branch changed many files, only the latest are checked, so that the check takes minutes instead of an hour."""
    sources = [name for name in checkout.named(".cpp") if name.startswith(("common/", "server/", "client/", "tests/"))]
    if every:
        return sources
    known, headers = set(sources), set(checkout.named(".hpp"))
    if not checkout.has_history:
        print("check tidy: skipped, because without git history the changed files are unknown; --all checks all files", flush=True)
        return []
    wanted = {}
    for name in checkout.changed:
        if name in known:
            wanted[name] = True
        elif name in headers:
            own = name.removesuffix(".hpp") + ".cpp"
            include = f'#include "{name}"'
            seen_by = [own] if own in known else [source for source in sources if include in checkout.read(source)]
            wanted.update(dict.fromkeys(seen_by[:1], True))
    if len(wanted) > MOST_TIDIED:
        print(f"check tidy: checks the latest {MOST_TIDIED} of {len(wanted)} changed files; --all checks all files", flush=True)
    return list(wanted)[:MOST_TIDIED]


def check_tidy(checkout, every):
    files = tidied_files(checkout, every)
    if not files:
        return []
    try:
        files = [name for name in files if name in checkout.compile_commands]
    except NotConfigured as failed:
        return [str(failed)]

    def tidy(name):
        _, output = checkout.run("clang-tidy", "--quiet", "-p", "build/tidy",
                                 "--extra-arg=-Wno-unknown-warning-option", name)
        return [line.removeprefix(f"{checkout.root}/") for line in output.splitlines()
                if re.search(r":\d+:\d+: (error|warning): ", line)]

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        found = [line for lines in pool.map(tidy, files) for line in lines]
    return list(dict.fromkeys(found))
