"""The client: one server, and everything that the interface has."""
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
    """Asks one server. Thread-safe: one client for a whole program, whose threads share its connections.

        with Client("http://127.0.0.1:8080") as client:
            mesh = client.put("barrel.glb")
            answer = mesh.fracture(material="wood", fragments=40)
            answer.save("broken.glb")

    Every call takes `timeout` (s, for everything that is tried again; None: the client's) and `cancel` (a Cancel, for another
    thread). What goes wrong on the way is tried again; what is left raises FractureError.
    """

    def __init__(self, url: str, token: Optional[str] = None, timeout: Optional[float] = 300.0, *, realtime: bool = False,
                 tls: Optional[ssl.SSLContext] = None, settings: Settings = Settings()) -> None:
        """
        url       "http://127.0.0.1:8080"; https checks the certificate
        token     sent as `Authorization: Bearer …`
        timeout   s of each call, with everything that is tried again; None: as long as tries last
        realtime  fractures go before batch work, with the server's short deadline (2 s by default), as a game wants it
        tls       whom to believe; None: those that this system trusts
        settings  how often and how long the server is asked
        Does not connect yet. Raises FractureError: "bad-url", or "bad-parameter" for a token that cannot be sent.
        """
        super().__init__(url, token, timeout, realtime, tls, settings)

    def __enter__(self) -> "Client":
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    # -- meshes

    def put(self, mesh: Union[Path, Content], *, files: Optional[Files] = None, format: Optional[str] = None,
            timeout: Optional[float] = None, cancel: Optional[Cancel] = None, **preparation: Any) -> Mesh:
        """Makes a mesh known to the server. One that the server has already is not sent again.

        mesh         a path, or the bytes
        files        what the mesh names (.bin, .mtl, textures): {name: path or bytes}, or paths. None: of a path, what it
                     names, from its folder and below; () for nothing
        format       "glb", "obj", …, where neither ending nor first bytes say it
        preparation  what decides the solid (`unit`, `up`, `repair`, `nodes`, `material` of a wall, …): the mesh is prepared with
                     it when it is sent, and its fractures have it unless they say otherwise
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
        """A mesh that the server has, by its id ("sha256:…"). Asks nobody. It cannot be sent again when it is forgotten."""
        if not re.fullmatch(r"sha256:[0-9a-f]{64}", id):
            raise FractureError("bad-parameter", f"'{id}' is no id of a mesh: 'sha256:' and 64 hex digits.", parameter="id")
        return Mesh(self, id)

    def inspect(self, mesh: Union[Path, Content], *, files: Optional[Files] = None, format: Optional[str] = None,
                timeout: Optional[float] = None, cancel: Optional[Cancel] = None, **preparation: Any) -> Dict[str, Any]:
        """What a mesh is worth, without fracturing it: verdict, solid, frame, nodes, materials, images, warnings. It is sent,
        prepared with what is given, and stored. Raises FractureError; of a mesh that is of no use, too."""
        upload = Upload.of(mesh, files, format)
        kind, body = upload.body()
        target = "/meshes" + query_of({**upload.query, **preparation})
        response = self._ask("POST", target, body, {"Content-Type": kind}, asking.check_json, timeout, cancel)
        return (asking.json_object(response.body) or {}).get("report", {})

    # -- fractures

    def fracture(self, mesh: AnyMesh, parameters: Optional[Parameters] = None, *, files: Optional[Files] = None,
                 format: Optional[str] = None, timeout: Optional[float] = None, cancel: Optional[Cancel] = None,
                 realtime: Optional[bool] = None, **more: Any) -> Answer:
        """Mesh and parameters in one request, for what is broken once; of a Mesh the same as Mesh.fracture(). Raises
        FractureError, and OSError for a file that cannot be read."""
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
        """An answer again, by its address (Answer.location), while the server has it cached. `unless`: an etag that is known:
        None where the answer is still that one. Raises FractureError; "not-found" where it is not cached any more."""
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
        """Starts a fracture that nobody waits for on a connection (Mesh.job()). Where the connection breaks between request
        and answer a second job is started, which shares the computation of the first. Raises FractureError."""
        if not isinstance(mesh, Mesh):
            mesh = self.put(mesh, timeout=timeout, cancel=cancel)
        response = mesh._ask(parameters, more, "model/gltf-binary", asking.check_json, timeout, cancel, False, {"Prefer": "respond-async"})
        return Job(self, JobState.of(asking.json_object(response.body) or {}), mesh)

    def find_job(self, id: str, *, timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> Job:
        """A job that was started before, maybe by another program. Raises FractureError; "not-found" for none."""
        return Job(self, JobState.of(self._json("GET", "/jobs/" + urllib.parse.quote(id, safe=""), timeout, cancel)))

    def jobs(self, state: Optional[str] = None, *, timeout: Optional[float] = None,
             cancel: Optional[Cancel] = None) -> Iterator[Job]:
        """One's jobs, the newest first; `state`: "queued", "running", "done", "failed", "cancelled". Asks page by page while
        they are iterated. Raises FractureError."""
        target = "/jobs" + query_of({"state": state, "limit": 100})
        while target:
            page = self._json("GET", target, timeout, cancel)
            for document in page.get("jobs", []):
                yield Job(self, JobState.of(document))
            target = str(page.get("next") or "")

    # -- discovery

    def index(self, *, timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> Dict[str, Any]:
        """What this is, and where to go from here."""
        return self._json("GET", "/", timeout, cancel)

    def version(self, *, timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> Dict[str, Any]:
        """`name`, `version` of the server, `algorithm`."""
        return self._json("GET", "/version", timeout, cancel)

    def limits(self, *, timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> Dict[str, Any]:
        """Sizes, times and formats, and every parameter with its type, unit, range and default."""
        return self._json("GET", "/limits", timeout, cancel)

    def patterns(self, *, timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> Dict[str, Any]:
        """How a mesh may break: `patterns`, `materials` and `parameters`."""
        return self._json("GET", "/patterns", timeout, cancel)

    def openapi(self, *, timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> Dict[str, Any]:
        """The interface as OpenAPI 3.1."""
        return self._json("GET", "/openapi.json", timeout, cancel)

    def explain(self, problem: Union[str, FractureError], *, timeout: Optional[float] = None,
                cancel: Optional[Cancel] = None) -> str:
        """What a type of problem means and what to do, for people."""
        name = problem.type if isinstance(problem, FractureError) else problem.rsplit("/", 1)[-1]
        target = "/problems/" + urllib.parse.quote(name, safe="")
        response = self._ask("GET", target, b"", {"Accept": "text/plain"}, asking.check_nothing, timeout, cancel)
        return response.body.decode("utf-8", "replace")

    def request(self, method: str, path: str, *, body: bytes = b"", headers: Optional[Mapping[str, str]] = None,
                timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> Response:
        """Anything else that the interface has (the Range of a result, another Accept), with the same manners. `path`: with
        its query. A whole answer with a Repr-Digest is checked. Raises FractureError."""
        check = asking.check_nothing if method == "HEAD" else asking.check_digest_if_any
        return self._ask(method, path, body, headers or {}, check, timeout, cancel)
