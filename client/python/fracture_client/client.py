"""The client for a server, with a method for each operation of the interface."""
from __future__ import annotations

import re
import ssl
import urllib.parse
from typing import Any, Dict, Iterator, Mapping, Optional, Union

from . import asking
from .answer import Answer
from .caller import Caller, query_of
from .calls import Cancel
from .errors import FractureError
from .http1 import Request, Response
from .jobs import Job, JobState
from .mesh import Mesh, Parameters
from .pool import Settings
from .upload import Content, Files, Path, Upload

AnyMesh = Union[Mesh, Path, Content]


class Client(Caller):
    """A client for one server. It is thread-safe, so one per program is enough; all threads share its connections.

        with Client("http://127.0.0.1:8080") as client:
            mesh = client.put("barrel.glb")
            answer = mesh.fracture(material="wood", fragments=40)
            answer.save("broken.glb")

    Every call takes `timeout` (in seconds, retries included; None: the client's) and `cancel` (a Cancel that lets another thread
    end the call). The client repeats a request if the server is busy or the connection breaks. If this does not help, or if any other
    error occurs, it raises FractureError.
    """

    def __init__(self, url: str, token: Optional[str] = None, timeout: Optional[float] = 300.0, *, realtime: bool = False,
                 tls: Optional[ssl.SSLContext] = None, settings: Settings = Settings()) -> None:
        """
        url       such as "http://127.0.0.1:8080"; with https, the certificate is checked
        token     sent as `Authorization: Bearer …`
        timeout   seconds for each call, retries included; None: only `settings.tries` limits a call
        realtime  for games: fractures are computed before batch work, with the server's short deadline (2 s by default)
        tls       the certificates to trust; None: those of this system
        settings  timeouts, number of tries, number of connections
        The client does not connect yet. Raises FractureError of type "bad-url", or "bad-parameter" if the token cannot be sent.
        """
        super().__init__(url, token, timeout, realtime, tls, settings)

    def __enter__(self) -> "Client":
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    # -- meshes

    def put(self, mesh: Union[Path, Content], *, files: Optional[Files] = None, format: Optional[str] = None,
            timeout: Optional[float] = None, cancel: Optional[Cancel] = None, **preparation: Any) -> Mesh:
        """Stores a mesh on the server, unless the server already has it.

        mesh         a path, or the bytes of a file
        files        the files that the mesh references (.bin, .mtl, textures): {name: path or bytes}, or a list of paths. None:
                     the referenced files in the folder and subfolders of `mesh`, if `mesh` is a path; (): no files
        format       "glb", "obj", …; needed only if neither the file extension nor the first bytes show it
        preparation  parameters that shape the solid (`unit`, `up`, `repair`, `nodes`, `shell`, `material`, …). The server prepares the mesh with
                     these parameters. They are also the defaults for every fracture of this mesh.
        Raises FractureError, and OSError for a file that cannot be read.
        """
        upload = Upload.of(mesh, files, format)
        made = Mesh(self, upload.id, upload, preparation)
        request = Request("GET", f"/meshes/{upload.id}", {"Accept": "application/json"})
        with self._call(timeout, cancel, request.what) as call:
            try:
                made.stored = asking.json_object(self._send(call, request, asking.check_json).body) or {}
            except FractureError as error:
                if error.type != "not-found":
                    raise
                self._put(made, call)
        return made

    def mesh(self, id: str) -> Mesh:
        """Returns the stored mesh with this id ("sha256:…"). Sends no request. If the server forgets the mesh, the client cannot
        send it again. Raises FractureError of type "bad-parameter" for a malformed id."""
        if not re.fullmatch(r"sha256:[0-9a-f]{64}", id):
            raise FractureError("bad-parameter", f"'{id}' is not the id of a mesh: an id is 'sha256:' followed by 64 lower-case hex "
                                                 "digits.", parameter="id")
        return Mesh(self, id)

    def inspect(self, mesh: Union[Path, Content], *, files: Optional[Files] = None, format: Optional[str] = None,
                timeout: Optional[float] = None, cancel: Optional[Cancel] = None, **preparation: Any) -> Dict[str, Any]:
        """Reports on a mesh without fracturing it: verdict, solid, frame, nodes, materials, images, warnings, notes, dropped. The mesh is
        sent, prepared with `preparation`, and stored. Takes the same arguments as put(). Raises OSError, and FractureError, for
        example if the mesh cannot be fractured."""
        upload = Upload.of(mesh, files, format)
        kind, body = upload.body()
        target = "/meshes" + query_of({**upload.query, **preparation})
        response = self._ask("POST", target, body, {"Content-Type": kind}, asking.check_json, timeout, cancel)
        return (asking.json_object(response.body) or {}).get("report", {})

    # -- fractures

    def fracture(self, mesh: AnyMesh, parameters: Optional[Parameters] = None, *, files: Optional[Files] = None,
                 format: Optional[str] = None, timeout: Optional[float] = None, cancel: Optional[Cancel] = None,
                 realtime: Optional[bool] = None, **more: Any) -> Answer:
        """Sends the mesh and parameters in one request. Use this call for a mesh that you fracture only once. If `mesh` is a Mesh,
        calls mesh.fracture().

        mesh, files, format   as for put()
        parameters, realtime  as for Mesh.fracture()
        Raises FractureError, and OSError for a file that cannot be read.
        """
        if isinstance(mesh, Mesh):
            return mesh.fracture(parameters, timeout=timeout, cancel=cancel, realtime=realtime, **more)
        upload = Upload.of(mesh, files, format)
        query = "?" + parameters.lstrip("?") if isinstance(parameters, str) else ""
        given = {**upload.query, **({} if isinstance(parameters, str) else parameters or {}), **more}
        kind, form = upload.form(given)
        headers = {"Content-Type": kind, "Accept": "model/gltf-binary", **self._urgency(realtime)}
        response = self._ask("POST", "/fracture" + query, form, headers, asking.check_digest, timeout, cancel)
        return Answer(response.body, Mesh(self, upload.id, upload), response.headers)

    def answer(self, location: str, *, unless: Optional[str] = None, timeout: Optional[float] = None,
               cancel: Optional[Cancel] = None) -> Optional[Answer]:
        """Fetches an answer again by its address (Answer.location). `unless`: the etag of an answer that you already have. If that
        answer is still current, returns None. Raises FractureError of type "not-found" if the server's cache no longer has the answer."""
        target = "/fractures/" + urllib.parse.quote(location.rsplit("/", 1)[-1], safe=":")
        headers = {"Accept": "model/gltf-binary", **({"If-None-Match": unless} if unless else {})}
        response = self._ask("GET", target, b"", headers, asking.check_digest, timeout, cancel)
        if response.status == 304:
            return None
        answer = Answer(response.body, None, {"content-location": target, **response.headers})
        return answer.of_mesh(Mesh(self, str(answer.figures.get("mesh"))))

    # -- jobs

    def job(self, mesh: AnyMesh, parameters: Optional[Parameters] = None, *, timeout: Optional[float] = None,
            cancel: Optional[Cancel] = None, **more: Any) -> Job:
        """Starts a fracture as background work and returns at once; see Mesh.job(). If the connection breaks before the server
        responds, this starts a second job, which shares the computation of the first. Raises FractureError and OSError."""
        if not isinstance(mesh, Mesh):
            mesh = self.put(mesh, timeout=timeout, cancel=cancel)
        response = mesh._ask(parameters, more, "model/gltf-binary", asking.check_json, timeout, cancel, False, {"Prefer": "respond-async"})
        return Job(self, JobState.of(asking.json_object(response.body) or {}), mesh)

    def find_job(self, id: str, *, timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> Job:
        """Returns a job that was started earlier, possibly by another program. Raises FractureError of type "not-found" for an
        unknown id."""
        return Job(self, JobState.of(self._json("GET", "/jobs/" + urllib.parse.quote(id, safe=""), timeout, cancel)))

    def jobs(self, state: Optional[str] = None, *, timeout: Optional[float] = None,
             cancel: Optional[Cancel] = None) -> Iterator[Job]:
        """Yields your jobs, newest first. Fetches them in pages of 100. `state`: only jobs in this state ("queued", "running",
        "done", "failed" or "cancelled"). Raises FractureError."""
        target = "/jobs" + query_of({"state": state, "limit": 100})
        while target:
            page = self._json("GET", target, timeout, cancel)
            for document in page.get("jobs", []):
                yield Job(self, JobState.of(document))
            target = str(page.get("next") or "")

    # -- discovery

    def index(self, *, timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> Dict[str, Any]:
        """Returns the start page of the interface: the server's name, version and links. Raises FractureError."""
        return self._json("GET", "/", timeout, cancel)

    def version(self, *, timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> Dict[str, Any]:
        """Returns the server's `name` and `version`, and its `algorithm` version. Raises FractureError."""
        return self._json("GET", "/version", timeout, cancel)

    def limits(self, *, timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> Dict[str, Any]:
        """Returns the size and time limits, the formats, and every parameter with its type, unit, range and default. Raises
        FractureError."""
        return self._json("GET", "/limits", timeout, cancel)

    def patterns(self, *, timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> Dict[str, Any]:
        """Returns the server's `patterns` and `materials`, and the `parameters` that they take. Raises FractureError."""
        return self._json("GET", "/patterns", timeout, cancel)

    def openapi(self, *, timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> Dict[str, Any]:
        """Returns the OpenAPI 3.1 description of the interface. Raises FractureError."""
        return self._json("GET", "/openapi.json", timeout, cancel)

    def explain(self, problem: Union[str, FractureError], *, timeout: Optional[float] = None,
                cancel: Optional[Cancel] = None) -> str:
        """Returns a text that explains an error type and what to do about it. Raises FractureError."""
        name = problem.type if isinstance(problem, FractureError) else problem.rsplit("/", 1)[-1]
        target = "/problems/" + urllib.parse.quote(name, safe="")
        response = self._ask("GET", target, b"", {"Accept": "text/plain"}, asking.check_nothing, timeout, cancel)
        return response.body.decode("utf-8", "replace")

    def request(self, method: str, path: str, *, body: bytes = b"", headers: Optional[Mapping[str, str]] = None,
                timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> Response:
        """Sends a request that has no method in this class, for example to read a byte range of a result. Retries like all
        other calls. `path` includes the query. If a complete response has a Repr-Digest, the digest is checked. Raises FractureError."""
        check = asking.check_nothing if method == "HEAD" else asking.check_digest_if_any
        return self._ask(method, path, body, headers or {}, check, timeout, cancel)
