"""A mesh that the server knows by its digest."""
from __future__ import annotations

import urllib.parse
from typing import TYPE_CHECKING, Any, Dict, Mapping, Optional, Tuple, Union

from .answer import Answer
from .asking import Check, check_digest, check_figures, json_object
from .calls import Cancel
from .http1 import Response
from .upload import Upload, json_text

if TYPE_CHECKING:
    from .client import Client
    from .jobs import Job

# Parameters as the interface has them: a mapping, or the text of a query ("material=stone&fragments=40").
Parameters = Union[Mapping[str, Any], str]
# Bytes of JSON that the path of a stored mesh takes (max_parameters_bytes of GET /limits).
MOST_PARAMETER_BYTES = 4096


class Mesh:
    """Made by Client.put(). Thread-safe; keeps the bytes of the mesh, for a server that forgets it."""

    def __init__(self, client: "Client", id: str, upload: Optional[Upload] = None,
                 preparation: Optional[Mapping[str, Any]] = None) -> None:
        self._client = client
        self.id = id  # "sha256:…"
        self.upload = upload  # what is sent; None where that is not here
        self.preparation = dict(preparation or {})  # what decides the solid, unless a request says otherwise
        self.stored: Dict[str, Any] = {}  # what the server said of it: id, format, bytes, files, ttl_s, report

    @property
    def report(self) -> Dict[str, Any]:
        """What the mesh is worth: verdict ("closed" or "repaired"), solid, frame, nodes, materials, images, warnings. As the
        server said at put(); {} where nobody asked (refresh())."""
        return self.stored.get("report", {})

    def refresh(self, *, timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> Dict[str, Any]:
        """Asks what the server has of it: what `stored` is from then on. Raises FractureError; "not-found" where it has
        forgotten the mesh."""
        self.stored = self._client._json("GET", f"/meshes/{self.id}", timeout, cancel)
        return self.stored

    def fracture(self, parameters: Optional[Parameters] = None, *, timeout: Optional[float] = None,
                 cancel: Optional[Cancel] = None, realtime: Optional[bool] = None, **more: Any) -> Answer:
        """Breaks it. Parameters are those of the interface (proto/parameters.md, Client.patterns()), as keywords or as a
        mapping; a query text will do as well. What is None is left out.

            mesh.fracture(material="stone", fragments=40, impacts=[[0, 0.5, 0]])

        timeout   s for everything, tries included; None: the client's
        realtime  goes before batch work, with the server's short deadline (2 s by default); None: the client's
        Raises FractureError.
        """
        response = self._ask(parameters, more, "model/gltf-binary", check_digest, timeout, cancel, realtime)
        return Answer(response.body, self, response.headers)

    def figures(self, parameters: Optional[Parameters] = None, *, timeout: Optional[float] = None,
                cancel: Optional[Cancel] = None, realtime: Optional[bool] = None, **more: Any) -> Dict[str, Any]:
        """The figures of the same answer, without the geometry: what Answer.figures has. Raises FractureError."""
        response = self._ask(parameters, more, "application/json", check_figures, timeout, cancel, realtime)
        return json_object(response.body) or {}

    def job(self, parameters: Optional[Parameters] = None, *, timeout: Optional[float] = None,
            cancel: Optional[Cancel] = None, **more: Any) -> "Job":
        """Starts the fracture and does not wait for it. Background work: it stands still while anybody waits for another
        answer, and may take half an hour by default. Raises FractureError."""
        return self._client.job(self, parameters, timeout=timeout, cancel=cancel, **more)

    def forget(self, *, timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> bool:
        """Deletes it on the server. False where the server had forgotten it already. Raises FractureError."""
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
    """A query, and what is sent as JSON: with what the mesh was prepared with, where the request does not say otherwise. A hit
    (`of`) takes that from the answer that it names."""
    query = parameters.lstrip("?") if isinstance(parameters, str) else ""
    given = {**({} if isinstance(parameters, str) else parameters or {}), **more}
    named = set(urllib.parse.parse_qs(query, keep_blank_values=True))
    if "of" not in named | given.keys():
        given = {**{name: value for name, value in preparation.items() if name not in named}, **given}
    return f"?{query}" if query else "", given
