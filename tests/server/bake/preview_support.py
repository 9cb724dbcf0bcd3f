"""Support for the tests of previews: meshes, renderers that are scripts, and readers of PNG files and pages."""
import html.parser
import json
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

BOX = """v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8
"""
HOLED = BOX.replace("f 5 6 7 8", "f 5 6 7")  # the hole is filled, which causes a note
OPEN = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
VOID = {"meta", "img", "br", "link", "hr", "input"}

# A renderer as a script: it answers as draw_list.hpp describes, with a picture of a single colour.
SCRIPT = """#!{python}
import json, os, signal, struct, sys, zlib
open({log!r}, "a").write("%d\\n" % os.getpid())
def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
for text in sys.stdin:
    line = json.loads(text)
    width, height = map(int, line["size"].split("x"))
    assert open(line["file"], "rb").read(4) == b"glTF"
{body}
    with open(line["output"], "wb") as out:
        out.write(b"\\x89PNG\\r\\n\\x1a\\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) +
                  chunk(b"IDAT", zlib.compress(bytes((width + 1) * height))) + chunk(b"IEND", b""))
    print(json.dumps({{"output": line["output"]}}), flush=True)
"""


def png(path):
    """Returns the width, the height and the pixels (row by row) of a PNG with 8 bits of grey, RGB or RGBA."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n", path
    at, packed = 8, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        assert struct.unpack(">I", data[at + 8 + size:at + 12 + size])[0] == zlib.crc32(kind + body)
        if kind == b"IHDR":
            width, height, bits, color = struct.unpack(">IIBB", body[:10])
            assert bits == 8
            channels = {0: 1, 2: 3, 6: 4}[color]
        if kind == b"IDAT":
            packed += body
        at += 12 + size
    assert kind == b"IEND"
    raw, stride, rows, above = zlib.decompress(packed), width * channels, [], bytearray(width * channels)
    for y in range(height):
        method, row = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for x in range(stride):
            left = row[x - channels] if x >= channels else 0
            corner = above[x - channels] if x >= channels else 0
            up = above[x]
            if method == 1:
                row[x] = (row[x] + left) & 255
            elif method == 2:
                row[x] = (row[x] + up) & 255
            elif method == 3:
                row[x] = (row[x] + (left + up) // 2) & 255
            elif method == 4:
                guess = left + up - corner
                near = min((abs(guess - left), 0, left), (abs(guess - up), 1, up), (abs(guess - corner), 2, corner))[2]
                row[x] = (row[x] + near) & 255
        rows.append(bytes(row))
        above = row
    return width, height, channels, rows


class Page(html.parser.HTMLParser):
    """The contents of a page. Wrong nesting is an error."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.open, self.tags, self.rows, self.pictures, self.links, self.text = [], set(), [], [], [], ""
        self.feed(text)
        self.close()
        assert not self.open, self.open

    def handle_starttag(self, tag, attributes):
        self.tags.add(tag)
        given = dict(attributes)
        for name in given:
            assert not name.startswith("on"), name
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")
        if tag == "img":
            self.pictures.append(given)
        if tag == "a":
            self.links.append(given["href"])
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open and self.open.pop() == tag, f"</{tag}> is out of place"

    def handle_data(self, data):
        if "style" in self.open:
            assert "url(" not in data and "@import" not in data
            return
        self.text += data
        if "td" in self.open:
            self.rows[-1][-1] += data

    def meshes(self):
        return [row for row in self.rows if row and "".join(row)]


class Case(unittest.TestCase):
    """A folder with meshes. `program` is the path of fracture-server."""

    program = ""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.write("in/box.obj", BOX)
        self.write("in/sub/holed.obj", HOLED)
        self.write("in/open.obj", OPEN)

    def write(self, name, text):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return path

    def bake(self, *arguments, code=0, data=None, environment=None):
        ended = subprocess.run([self.program, "bake", *arguments, "--sites", "12"], cwd=self.folder, capture_output=True,
                               timeout=300, check=False, input=data, env={**os.environ, **(environment or {})})
        self.words = ended.stderr.decode("utf-8", "replace")
        self.assertEqual(ended.returncode, code, self.words)
        return ended.stdout

    def report(self, name="out/bake.ndjson"):
        return [json.loads(line) for line in (self.folder / name).read_text(encoding="utf-8").splitlines()]

    def page(self, name="r.html"):
        return Page((self.folder / name).read_text(encoding="utf-8"))

    def files(self, folder="."):
        return sorted(str(path.relative_to(self.folder)) for path in (self.folder / folder).rglob("*") if path.is_file())


class ScriptCase(Case):
    """A folder with meshes, and renderers that are scripts."""

    def renderer(self, body="", name="renderer"):
        """Makes a renderer script. self.starts() tells how often it was started."""
        script = SCRIPT.format(python=sys.executable, log=str(self.folder / "log"), body=body)
        path = self.write(name, script)
        path.chmod(0o755)
        return ["--renderer", str(path)]

    def starts(self):
        log = self.folder / "log"
        return len(log.read_text(encoding="utf-8").split()) if log.exists() else 0
