"""A mesh as it is sent: its files, the key that the server knows it by, and the form that carries several."""
from __future__ import annotations

import hashlib
import json
import os
import pathlib
import re
import urllib.parse
from dataclasses import dataclass
from typing import Any, Dict, Iterable, List, Mapping, Optional, Tuple, Union

from .errors import FractureError

Content = Union[bytes, bytearray, memoryview]
Path = Union[str, "os.PathLike[str]"]
# Further files of a mesh: under the names that the mesh has for them, or paths, which are known by their last component.
Files = Union[Mapping[str, Union[Content, Path]], Iterable[Path]]

MEDIA_TYPES = {"glb": "model/gltf-binary", "gltf": "model/gltf+json", "obj": "model/obj", "stl": "model/stl"}
MOST_FILES = 254  # of one form, beside the mesh


@dataclass(frozen=True)
class Upload:
    """A mesh with the files that it names. Its content is in memory."""

    content: bytes
    format: str  # as GET /limits names it: "glb"; "" where nothing says it
    files: Tuple[Tuple[str, bytes], ...]  # by name, ordered
    id: str  # "sha256:…"

    @classmethod
    def of(cls, mesh: Union[Path, Content], files: Optional[Files] = None, format: Optional[str] = None) -> "Upload":
        """Of a path or of bytes. `files`: None: of a path those that it names, from its folder and below; () for none.
        `format`: None: as the ending says, or the first bytes. Raises OSError for a file that cannot be read, and
        FractureError of type "bad-parameter" for a name that cannot be sent."""
        if isinstance(mesh, (bytes, bytearray, memoryview)):
            content = bytes(mesh)
            known = "glb" if content[:4] == b"glTF" else ""
            named = {} if files is None else _read(files)
        else:
            path = pathlib.Path(mesh)
            content = path.read_bytes()
            known = path.suffix[1:].lower()
            named = files_named_by(path, content) if files is None else _read(files)
        if len(named) > MOST_FILES:
            raise FractureError("bad-parameter", f"A mesh may have {MOST_FILES} further files; there are {len(named)}.",
                                parameter="files")
        for name in named:
            if not name or re.search(r"[\x00-\x1f\x7f]", name):
                raise FractureError("bad-parameter", f"A file cannot have the name {name!r}.", parameter="files")
        ordered = tuple(sorted(((name, named[name]) for name in named), key=lambda file: _encoded(file[0])))
        return cls(content, (format or known).lower(), ordered, mesh_id(content, ordered))

    def body(self) -> Tuple[str, bytes]:
        """Of PUT and POST /meshes: its Content-Type and its bytes."""
        if not self.files:
            return MEDIA_TYPES.get(self.format, "application/octet-stream"), self.content
        return self.form(None)

    @property
    def query(self) -> Dict[str, str]:
        """What has to be said where the Content-Type does not say the format."""
        return {"format": self.format} if self.format and self.format not in MEDIA_TYPES else {}

    def form(self, parameters: Optional[Mapping[str, Any]]) -> Tuple[str, bytes]:
        """multipart/form-data (RFC 7578). The boundary is made from the content's digest, which content cannot hold."""
        boundary = "fracture-" + self.id[-40:]
        kind = MEDIA_TYPES.get(self.format, "application/octet-stream")
        parts: List[bytes] = []
        if parameters is not None:
            parts += [_part(boundary, "params", None, "application/json"), json_text(parameters), b"\r\n"]
        parts += [_part(boundary, "mesh", f"mesh.{self.format or 'bin'}", kind), self.content, b"\r\n"]
        for name, content in self.files:
            parts += [_part(boundary, "file", name, "application/octet-stream"), content, b"\r\n"]
        parts.append(f"--{boundary}--\r\n".encode("ascii"))
        return f"multipart/form-data; boundary={boundary}", b"".join(parts)


def mesh_id(content: bytes, files: Iterable[Tuple[str, bytes]] = ()) -> str:
    """What the server knows the mesh by: the digest of its bytes; with further files, which are ordered by name, that of a
    list of all digests (the description of PUT /meshes/{id} in the interface has the rule)."""
    digest = hashlib.sha256(content).hexdigest()
    lines = b"".join(b"%d %b %b\n" % (len(_encoded(name)), _encoded(name), _hex(data)) for name, data in files)
    if lines:
        text = b"files\n" + digest.encode("ascii") + b"\n" + lines
        digest = hashlib.sha256(b"fracture files 2\n" + _hex(text)).hexdigest()
    return "sha256:" + digest


def _hex(data: bytes) -> bytes:
    return hashlib.sha256(data).hexdigest().encode("ascii")


def json_text(parameters: Mapping[str, Any]) -> bytes:
    """Parameters as the server reads them. Arrays and scalars of numpy are lists and numbers; what is None is left out.
    Raises FractureError of type "bad-parameter"."""
    texts: List[str] = []
    for name, value in parameters.items():
        if value is None:
            continue
        try:
            text = json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"), default=_plain)
        except (TypeError, ValueError) as error:
            raise FractureError("bad-parameter", f"'{name}' cannot be sent: {error}.", parameter=name) from None
        texts.append(json.dumps(str(name)) + ":" + text)
    return ("{" + ",".join(texts) + "}").encode("utf-8")


def files_named_by(path: pathlib.Path, content: bytes) -> Dict[str, bytes]:
    """What a glTF or OBJ names, and what its material libraries name, from its folder and below. A name that leads out of
    the folder is looked up by its last component, as the server does; what is not there is left out: the server says so."""
    kind = path.suffix[1:].lower()
    found: Dict[str, bytes] = {}
    if kind in ("gltf", "glb"):
        _add(found, path.parent, _named_by_gltf(content))
    elif kind == "obj":
        _add(found, path.parent, [rest for key, rest in _lines(content) if key == "mtllib"])
        for library in list(found.values()):
            _add(found, path.parent, _textures(library))
    return found


def _named_by_gltf(content: bytes) -> List[str]:
    if content[:4] == b"glTF":  # its first chunk is the JSON (glTF 2.0, section 4.4)
        content = content[20:20 + int.from_bytes(content[12:16], "little")]
    try:
        document = json.loads(content)
        lists = [document.get(key) for key in ("buffers", "images")]
    except (ValueError, AttributeError, RecursionError):
        return []  # the server says what is wrong with it
    entries = [entry for list_ in lists if isinstance(list_, list) for entry in list_ if isinstance(entry, dict)]
    uris = [entry["uri"] for entry in entries if isinstance(entry.get("uri"), str)]
    return [urllib.parse.unquote(uri) for uri in uris if not uri.startswith("data:")]


def _lines(content: bytes) -> Iterable[Tuple[str, str]]:
    """Keyword and rest of each line of an OBJ or MTL file that has both."""
    for match in re.finditer(rb"^[ \t]*(\S+)[ \t]+([^\r\n]*\S)", content, re.MULTILINE):
        yield match.group(1).decode("utf-8", "surrogateescape"), match.group(2).decode("utf-8", "surrogateescape")


def _textures(library: bytes) -> List[str]:
    names = []
    for key, rest in _lines(library):
        if key.startswith("map_") or key in ("bump", "norm", "disp", "decal", "refl"):
            # Options such as `-bm 0.2` stand before the name; a name may hold blanks, but not after options.
            names.append(rest.split()[-1] if rest.startswith("-") else rest)
    return names


def _add(found: Dict[str, bytes], folder: pathlib.Path, names: Iterable[str]) -> None:
    for name in names:
        name = name.replace("\\", "/").strip()
        name = name[2:] if name.startswith("./") else name
        if not name or "://" in name:
            continue
        plain = not name.startswith("/") and ":" not in name and ".." not in name.split("/")
        candidates = [name, name.rsplit("/", 1)[-1]] if plain else [name.rsplit("/", 1)[-1]]
        for candidate in candidates:
            file = _inside(folder, candidate)
            if file is not None:
                if candidate not in found:
                    found[candidate] = file.read_bytes()
                break


def _inside(folder: pathlib.Path, name: str) -> Optional[pathlib.Path]:
    """The file, where it is one and lies in the folder or below, links followed."""
    try:
        root, file = folder.resolve(), (folder / name).resolve()
        return file if file.is_file() and root in file.parents else None
    except (OSError, ValueError, RuntimeError):
        return None


def _read(files: Files) -> Dict[str, bytes]:
    if isinstance(files, Mapping):
        return {name: bytes(value) if isinstance(value, (bytes, bytearray, memoryview)) else pathlib.Path(value).read_bytes()
                for name, value in files.items()}
    if isinstance(files, (str, os.PathLike)):
        files = [files]
    return {pathlib.Path(file).name: pathlib.Path(file).read_bytes() for file in files}


def _encoded(name: str) -> bytes:
    return name.encode("utf-8", "surrogateescape")


def _part(boundary: str, name: str, filename: Optional[str], kind: str) -> bytes:
    head = f'--{boundary}\r\nContent-Disposition: form-data; name="{name}"'
    if filename is not None:
        quoted = filename.replace("\\", "\\\\").replace('"', '\\"')
        head += f'; filename="{quoted}"'
    return _encoded(f"{head}\r\nContent-Type: {kind}\r\n\r\n")


def _plain(value: Any) -> Any:
    if hasattr(value, "tolist"):  # numpy, array
        return value.tolist()
    raise TypeError(f"a {type(value).__name__} is no text, number, list or boolean")
