"""A mesh and its additional files as bytes, the mesh's id on the server, and the form that sends them."""
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
# Additional files of a mesh: {name in the mesh: content or path}, or paths whose last component is the name.
Files = Union[Mapping[str, Union[Content, Path]], Iterable[Path]]

MEDIA_TYPES = {"glb": "model/gltf-binary", "gltf": "model/gltf+json", "obj": "model/obj", "stl": "model/stl"}
MOST_FILES = 254  # maximum number of files per form, in addition to the mesh


@dataclass(frozen=True)
class Upload:
    """A mesh and its additional files in memory."""

    content: bytes
    format: str  # a format name from GET /limits, such as "glb"; "" if it is unknown
    files: Tuple[Tuple[str, bytes], ...]  # (name, content), ordered by name
    id: str  # "sha256:…"

    @classmethod
    def of(cls, mesh: Union[Path, Content], files: Optional[Files] = None, format: Optional[str] = None) -> "Upload":
        """Reads a mesh.

        mesh    a path, or the bytes of a file
        files   additional files; None: the referenced files in the folder and subfolders of `mesh`, if `mesh` is a path; (): no files
        format  None: derived from the file extension or the first bytes
        Raises OSError for a file that cannot be read, and FractureError of type "bad-parameter" for a name that cannot be sent.
        """
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
            raise FractureError("bad-parameter", f"The mesh has {len(named):,} additional files; at most {MOST_FILES} are allowed. "
                                                 "Send the mesh as a single GLB that contains its textures.", parameter="files")
        for name in named:
            if not name or re.search(r"[\x00-\x1f\x7f]", name):
                raise FractureError("bad-parameter", f"An additional file has the name {name!r}. Names must not be empty or contain "
                                                     "control characters.", parameter="files")
        ordered = tuple(sorted(((name, named[name]) for name in named), key=lambda file: _encoded(file[0])))
        return cls(content, (format or known).lower(), ordered, mesh_id(content, ordered))

    def body(self) -> Tuple[str, bytes]:
        """Returns (Content-Type, bytes) for PUT and POST /meshes."""
        if not self.files:
            return MEDIA_TYPES.get(self.format, "application/octet-stream"), self.content
        return self.form(None)

    @property
    def query(self) -> Dict[str, str]:
        """Returns the parameter `format`, or {} if the Content-Type shows the format."""
        return {"format": self.format} if self.format and self.format not in MEDIA_TYPES else {}

    def form(self, parameters: Optional[Mapping[str, Any]]) -> Tuple[str, bytes]:
        """Returns (Content-Type, bytes) of a multipart/form-data body (RFC 7578). The boundary is derived from the content's
        digest, so the content does not contain it."""
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
    """Returns the id of a mesh on the server: the SHA-256 of its bytes. If there are additional files, which must be sorted by
    name, the id is the SHA-256 of a list of all digests (rule: PUT /meshes/{id} in proto/openapi.yaml)."""
    digest = hashlib.sha256(content).hexdigest()
    lines = b"".join(b"%d %b %b\n" % (len(_encoded(name)), _encoded(name), _hex(data)) for name, data in files)
    if lines:
        text = b"files\n" + digest.encode("ascii") + b"\n" + lines
        digest = hashlib.sha256(b"fracture files 2\n" + _hex(text)).hexdigest()
    return "sha256:" + digest


def _hex(data: bytes) -> bytes:
    return hashlib.sha256(data).hexdigest().encode("ascii")


def json_text(parameters: Mapping[str, Any]) -> bytes:
    """Returns the parameters as a JSON object. Numpy arrays and scalars become lists and numbers; None is omitted. Raises
    FractureError of type "bad-parameter" for a value that JSON cannot represent."""
    texts: List[str] = []
    for name, value in parameters.items():
        if value is None:
            continue
        try:
            text = json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"), default=_plain)
        except (TypeError, ValueError) as error:
            raise FractureError("bad-parameter", f"The value of '{name}' cannot be sent as JSON: {error}.", parameter=name) from None
        texts.append(json.dumps(str(name)) + ":" + text)
    return ("{" + ",".join(texts) + "}").encode("utf-8")


def files_named_by(path: pathlib.Path, content: bytes) -> Dict[str, bytes]:
    """Returns {name: content} for each file that a glTF, or an OBJ and its material libraries, references. Files are searched for
    in the mesh's folder and its subfolders. If a name leads outside the folder, only its last component is used, as on the server.
    Missing files are omitted; the server reports them."""
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
    if content[:4] == b"glTF":  # the first chunk is the JSON (glTF 2.0, section 4.4)
        content = content[20:20 + int.from_bytes(content[12:16], "little")]
    try:
        document = json.loads(content)
        lists = [document.get(key) for key in ("buffers", "images")]
    except (ValueError, AttributeError, RecursionError):
        return []  # the server reports the error
    entries = [entry for list_ in lists if isinstance(list_, list) for entry in list_ if isinstance(entry, dict)]
    uris = [entry["uri"] for entry in entries if isinstance(entry.get("uri"), str)]
    return [urllib.parse.unquote(uri) for uri in uris if not uri.startswith("data:")]


def _lines(content: bytes) -> Iterable[Tuple[str, str]]:
    """Yields (keyword, rest of the line) for each line of an OBJ or MTL file that has both."""
    for match in re.finditer(rb"^[ \t]*(\S+)[ \t]+([^\r\n]*\S)", content, re.MULTILINE):
        yield match.group(1).decode("utf-8", "surrogateescape"), match.group(2).decode("utf-8", "surrogateescape")


def _textures(library: bytes) -> List[str]:
    names = []
    for key, rest in _lines(library):
        if key.startswith("map_") or key in ("bump", "norm", "disp", "decal", "refl"):
            # Options such as `-bm 0.2` precede the name. A name may contain spaces, but not after options.
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
    """Returns the file if it exists inside the folder or a subfolder (after following links), else None."""
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
    raise TypeError(f"a value of type {type(value).__name__} is not a string, number, list or boolean")
