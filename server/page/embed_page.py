#!/usr/bin/env python3
"""embed_page.py CLIENT_FOLDER OUT_FOLDER [--without]: builds client/page with npm and writes OUT_FOLDER/page_files.cpp, which
contains the page.

If npm is missing, or cannot fetch the packages in package-lock.json, the file contains no page, and a warning says why. The server then
tells browsers that it has no page; everything else works. A page that does not compile is an error. Several builds of one checkout
take turns.
"""
import fcntl
import gzip
import hashlib
import pathlib
import shutil
import subprocess
import sys

TYPES = {".html": "text/html; charset=utf-8", ".js": "text/javascript; charset=utf-8", ".css": "text/css; charset=utf-8",
         ".svg": "image/svg+xml", ".png": "image/png", ".jpg": "image/jpeg", ".wasm": "application/wasm",
         ".json": "application/json", ".txt": "text/plain; charset=utf-8"}
LONGEST = 600  # maximum seconds for one npm command


def run(command, folder):
    """Runs the command. Returns an error message if the command fails, otherwise an empty string."""
    try:
        done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=LONGEST)
    except subprocess.TimeoutExpired:
        return f"{' '.join(command)} took more than {LONGEST} s"
    return "" if done.returncode == 0 else f"{' '.join(command)} ended with {done.returncode}:\n{done.stdout[-2000:]}"


def build(page):
    """Builds the page in page/dist. Returns an error message if the build fails, otherwise an empty string."""
    if not (page / "package.json").exists():
        return f"{page} does not contain a package.json"
    if not shutil.which("npm"):
        return "npm is missing"
    modules, lock = page / "node_modules", page / "package-lock.json"
    installed = modules / ".installed"  # copy of the lock file from which the modules were installed
    if not installed.exists() or installed.read_bytes() != lock.read_bytes():
        if why := run(["npm", "ci", "--no-audit", "--no-fund"], page):
            return why
        shutil.copyfile(lock, installed)
    if why := run(["npm", "run", "build"], page):
        sys.exit(why)
    return ""


def literal(text):
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def main():
    client, out = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    page, blob, entries = client / "page", b"", []
    why = "FRACTURE_PAGE is OFF" if "--without" in sys.argv else ""
    if not why:
        with open(__file__, "rb") as turn:
            fcntl.flock(turn, fcntl.LOCK_EX)
            why = build(page)
            dist = page / "dist"
            for path in sorted(p for p in dist.rglob("*") if p.is_file()) if not why else ():
                plain = path.read_bytes()
                packed = gzip.compress(plain, 9, mtime=0)
                name = path.relative_to(dist).as_posix().removeprefix("page/")
                entries.append(f"    {{{literal(name)}, {literal(TYPES[path.suffix])}, \"{hashlib.sha256(plain).hexdigest()[:16]}\", "
                               f"{{kBytes + {len(blob)}, {len(packed)}}}, {{kBytes + {len(blob) + len(packed)}, {len(plain)}}}}},")
                blob += packed + plain
    if why:
        print(f"warning: the server is built without its page: {why}", file=sys.stderr)
    out.mkdir(parents=True, exist_ok=True)
    (out / "page.bin").write_bytes(blob)
    text = '// Generated from client/page.\n#include "server/page/page.hpp"\n\n'
    if entries:
        # The assembler includes the bytes, because the compiler would take half a minute to read them as an array of numbers.
        included = literal(literal(str(out / "page.bin")))
        text += (f"// {hashlib.sha256(blob).hexdigest()}\n"
                 f'__asm__(".section .rodata\\n.balign 16\\nfracture_page_bytes:\\n.incbin " {included} "\\n.previous\\n");\n'
                 'extern "C" __attribute__((visibility("hidden"))) const std::uint8_t fracture_page_bytes[];\n\n')
        text += ("std::span<const fracture::page::File> fracture::page::files() {\n"
                 "  static const std::uint8_t* const kBytes = fracture_page_bytes;\n"
                 "  static const File kFiles[] = {\n" + "\n".join(entries) + "\n  };\n  return kFiles;\n}\n")
    else:
        text += "std::span<const fracture::page::File> fracture::page::files() { return {}; }\n"
    (out / "page_files.cpp").write_text(text)


main()
