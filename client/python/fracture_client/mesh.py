"""A mesh that is stored on the server under its digest."""
from __future__ import annotations

import urllib.parse
from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Optional, Tuple, Union

from .answer import Answer
from .asking import Check, check_digest, check_figures, check_json, json_object
from .calls import Cancel
from .choices import Choice, read_choices
from .dropped import Dropped, read_dropped
from .http1 import Response
from .upload import Upload, json_text

if TYPE_CHECKING:
    from .client import Client
    from .jobs import Job

# Parameters of the interface: a mapping, or a query ("material=stone&fragments=40").
Parameters = Union[Mapping[str, Any], str]
# Maximum bytes of JSON in a request about a stored mesh (max_parameters_bytes of GET /limits).
MOST_PARAMETER_BYTES = 64 * 1024


class Mesh:
    """A mesh on the server, created by Client.put(). Thread-safe. This object keeps the bytes so that it can send them again if the
    server forgets the mesh."""

    def __init__(self, client: "Client", id: str, upload: Optional[Upload] = None,
                 preparation: Optional[Mapping[str, Any]] = None) -> None:
        self._client = client
        self.id = id  # "sha256:…"
        self.upload = upload  # the files to send; None if only the id is known
        self.preparation = dict(preparation or {})  # parameters that shape the solid; also the defaults for its fractures
        self.stored: Dict[str, Any] = {}  # the server's description: id, format, bytes, files, ttl_s, report

    @property
    def report(self) -> Dict[str, Any]:
        """The server's report on the mesh: verdict ("closed" or "repaired"), solid, volume_once, frame, nodes, materials, images,
        warnings, notes, choices, dropped. The report comes from put() or the latest refresh(); {} before these calls."""
        return self.stored.get("report", {})

    @property
    def choices(self) -> List[Choice]:
        """Changes that the server offers for this mesh, but makes only on request. [] before put() or refresh()."""
        return read_choices(self.report)

    @property
    def dropped(self) -> List[Dropped]:
        """Things in the file that answers do not contain, such as lights and animations. [] before put() or refresh()."""
        return read_dropped(self.report)

    def refresh(self, *, timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> Dict[str, Any]:
        """Fetches the server's description of the mesh, returns it, and keeps it in `stored`. Raises FractureError of type "not-found" if the
        server has forgotten the mesh."""
        self.stored = self._client._json("GET", f"/meshes/{self.id}", timeout, cancel)
        return self.stored

    def fracture(self, parameters: Optional[Parameters] = None, *, timeout: Optional[float] = None,
                 cancel: Optional[Cancel] = None, realtime: Optional[bool] = None, **more: Any) -> Answer:
        """Breaks the mesh.

            mesh.fracture(material="stone", fragments=40, impacts=[[0, 0.5, 0]])

        parameters  the interface's parameters (proto/parameters.md, Client.patterns()), as keywords, a mapping or a query string.
                    Parameters that are None are omitted.
        timeout     seconds for everything, retries included; None: the client's
        realtime    True: computed before batch work, with the server's short deadline (2 s by default); None: the client's setting
        Raises FractureError.
        """
        response = self._ask(parameters, more, "model/gltf-binary", check_digest, timeout, cancel, realtime)
        return Answer(response.body, self, response.headers)

    def figures(self, parameters: Optional[Parameters] = None, *, timeout: Optional[float] = None,
                cancel: Optional[Cancel] = None, realtime: Optional[bool] = None, **more: Any) -> Dict[str, Any]:
        """Breaks the mesh and returns only the data (Answer.figures), not the geometry. Takes the same arguments as fracture(). Raises
        FractureError."""
        response = self._ask(parameters, more, "application/json", check_figures, timeout, cancel, realtime)
        return json_object(response.body) or {}

    def estimate(self, parameters: Optional[Parameters] = None, *, timeout: Optional[float] = None,
                 cancel: Optional[Cancel] = None, **more: Any) -> Dict[str, Any]:
        """Estimates the answer of fracture() with these arguments, without computing it. Returns sites, fragments, triangles, bytes,
        working_bytes, limit_bytes, fits, costliest and advice. The numbers are usually within a factor of two. Raises FractureError."""
        query, given = _split(parameters, more, self.preparation)
        target, fields = f"/meshes/{self.id}/estimate" + query, {"Accept": "application/json", "Content-Type": "application/json"}
        response = self._client._ask("POST", target, json_text(given), fields, check_json, timeout, cancel, self)
        return json_object(response.body) or {}

    def job(self, parameters: Optional[Parameters] = None, *, timeout: Optional[float] = None,
            cancel: Optional[Cancel] = None, **more: Any) -> "Job":
        """Starts the fracture as background work and returns at once. The job pauses while any client is waiting for an
        answer. Its default time limit is half an hour. Raises FractureError."""
        return self._client.job(self, parameters, timeout=timeout, cancel=cancel, **more)

    def forget(self, *, timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> bool:
        """Deletes the mesh on the server. Returns False if the server does not have it. Raises FractureError."""
        return self._client._delete(f"/meshes/{self.id}", timeout, cancel)

    def _ask(self, parameters: Optional[Parameters], more: Mapping[str, Any], accept: str, check: Check,
             timeout: Optional[float], cancel: Optional[Cancel], realtime: Optional[bool],
             headers: Optional[Mapping[str, str]] = None) -> Response:
        query, given = _split(parameters, more, self.preparation)
        body = json_text(given)
        fields = {"Accept": accept, **self._client._urgency(realtime), **(headers or {})}
        if len(body) > MOST_PARAMETER_BYTES and self.upload is not None:  # thousands of `points`, for example
            kind, form = self.upload.form({**self.upload.query, **given})
            target = "/fracture" + query
            return self._client._ask("POST", target, form, {**fields, "Content-Type": kind}, check, timeout, cancel)
        target = f"/meshes/{self.id}/fracture" + query
        return self._client._ask("POST", target, body, {**fields, "Content-Type": "application/json"}, check, timeout, cancel,
                                 self)

    def __repr__(self) -> str:
        return f"<Mesh {self.id}>"


def _split(parameters: Optional[Parameters], more: Mapping[str, Any],
           preparation: Mapping[str, Any]) -> Tuple[str, Dict[str, Any]]:
    """Returns (query, parameters for the JSON body). The mesh's preparation supplies defaults. A hit does not need these defaults,
    because the server takes them from the answer that `of` names."""
    query = parameters.lstrip("?") if isinstance(parameters, str) else ""
    given = {**({} if isinstance(parameters, str) else parameters or {}), **more}
    named = set(urllib.parse.parse_qs(query, keep_blank_values=True))
    if "of" not in named | given.keys():
        given = {**{name: value for name, value in preparation.items() if name not in named}, **given}
    return f"?{query}" if query else "", given
