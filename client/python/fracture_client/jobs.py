"""Jobs: fractures that the server computes in the background."""
from __future__ import annotations

import json
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Dict, Iterator, List, Optional

from .answer import Answer
from .asking import refusal
from .calls import Call, Cancel
from .errors import FractureError
from .http1 import Request, Response, Trouble

if TYPE_CHECKING:
    from .client import Client
    from .mesh import Mesh

STATES = ("queued", "running", "done", "failed", "cancelled")
FINISHED = STATES[2:]
LONGEST_WAIT = 30.0  # s; longest time that a request waits for a job to finish, shorter than the timeouts of common proxies
SHORTEST_LOOK = 1.0  # s between two requests for the state of a job
MOST_EVENT_BYTES = 1 << 20  # an event of a job normally has a few hundred bytes


@dataclass(frozen=True)
class JobState:
    """The state of a job at one moment."""

    id: str
    state: str  # "queued", "running", "done", "failed", "cancelled"
    stage: str  # "", "import", "prepare", "tetrahedralize", "clip", "encode"
    percent: int  # never decreases while the server runs
    created: str  # time in RFC 3339
    finished: str  # time in RFC 3339; "" until the job has finished
    durable: bool  # True if the job survives a restart of the server
    queue_position: Optional[int]  # number of jobs ahead while the job is queued, else None
    result: str  # address of the answer if the job is done, else ""
    error: Dict[str, Any]  # the problem document if the job has failed, else {}
    document: Dict[str, Any] = field(repr=False)  # the whole document from the server

    @property
    def is_finished(self) -> bool:
        """Whether the job is done, failed or cancelled."""
        return self.state in FINISHED

    @classmethod
    def of(cls, document: Dict[str, Any]) -> "JobState":
        """Reads the state from a server document. Raises FractureError of type "damaged" if a member is missing or malformed."""
        try:
            return cls(str(document["id"]), str(document["state"]), str(document["stage"]), int(document["percent"]),
                       str(document["created"]), str(document.get("finished", "")), bool(document["durable"]),
                       document.get("queue_position"), str(document.get("result", "")), dict(document.get("error", {})),
                       document)
        except (KeyError, TypeError, ValueError) as error:
            raise FractureError("damaged", f"The response does not describe a job: {error!r}.") from None


class Job:
    """A job on the server. Not thread-safe, except cancel()."""

    def __init__(self, client: "Client", state: JobState, mesh: Optional["Mesh"] = None) -> None:
        self._client = client
        self._mesh = mesh
        self.state = state  # the last known state

    @property
    def id(self) -> str:
        return self.state.id

    def refresh(self, *, timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> JobState:
        """Asks the server for the job's state, and returns it. Raises FractureError of type "not-found" if the server has forgotten
        the job."""
        self.state = JobState.of(self._client._json("GET", f"/jobs/{self.id}", timeout, cancel))
        return self.state

    def progress(self, *, timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> Iterator[JobState]:
        """Yields the state whenever it changes (server-sent events), until the job has finished. Reopens a broken stream.
        `timeout`: seconds for the whole iteration; None: only the server's limit applies. Raises FractureError."""
        settings = self._client.settings
        request = self._client._complete(Request("GET", f"/jobs/{self.id}/events", {"Accept": "text/event-stream"}))
        pause, tries = settings.first_pause, 0
        with self._client._call(timeout, cancel, request.what, forever=True) as call:
            while not self.state.is_finished or tries == 0:
                heard = False
                try:
                    for state in self._listen(request, call):
                        if state != self.state or not (heard or tries):
                            self.state = state
                            yield state
                        heard = True
                        if state.is_finished:
                            return
                    failure = FractureError("connection", f"{request.what}: the stream of events ended before the job had finished.")
                except Trouble as trouble:
                    failure = FractureError(trouble.type, f"{request.what}: {trouble.detail}")
                if heard:  # a try counts only if no event arrived
                    pause, tries = settings.first_pause, 0
                tries += 1
                left = call.remaining()
                if tries >= settings.tries or (left is not None and left <= pause):
                    raise failure
                call.pause(pause)
                pause = min(2 * pause, settings.longest_pause)

    def wait(self, *, timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> JobState:
        """Waits until the job has finished. `timeout`: seconds; None: no limit. Raises FractureError. After an error of type "timeout",
        the job continues to run."""
        end = None if timeout is None else time.monotonic() + timeout
        longest = max(1.0, min(LONGEST_WAIT, self._client.settings.answer_timeout / 2))
        while not self.state.is_finished:
            left = longest if end is None else min(longest, end - time.monotonic())
            if left <= 0:
                raise FractureError("timeout", f"Job {self.id} did not finish within {timeout:g} s; it is at "
                                               f"{self.state.percent} % and is still running. Call wait() again, or cancel().")
            asked = time.monotonic()
            headers = {"Prefer": f"wait={int(left)}"} if left >= 1 else {}
            self.state = JobState.of(self._client._json("GET", f"/jobs/{self.id}", None, cancel, headers))
            if not self.state.is_finished:  # a server or proxy that ignores `wait` answers at once
                (cancel or Cancel()).wait(max(0.0, min(left, SHORTEST_LOOK) - (time.monotonic() - asked)))
        return self.state

    def result(self, *, timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> Answer:
        """Waits until the job has finished and returns its answer. `timeout`: seconds for the wait, and the same time again for
        fetching the answer. Raises the job's FractureError if it failed or was cancelled, FractureError of type "job-lost" if the server
        had to remove the result, and "not-found" if it has forgotten the job."""
        state = self.wait(timeout=timeout, cancel=cancel)
        if state.state != "done":
            if state.error:
                raise FractureError.of_problem(state.error)
            raise FractureError("cancelled", f"Job {self.id} was cancelled.")
        answer = self._client.answer(state.result, timeout=timeout, cancel=cancel)
        assert answer is not None  # None only with `unless`
        return answer if self._mesh is None else answer.of_mesh(self._mesh)

    def cancel(self, *, timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> bool:
        """Stops the job, or deletes it if it has finished. Any thread may call this. Returns False if the server does not have the
        job. Raises FractureError."""
        return self._client._delete(f"/jobs/{self.id}", timeout, cancel)

    def _listen(self, request: Request, call: Call) -> Iterator[JobState]:
        """Yields the states in the event stream. Raises Trouble, and FractureError if the response is not such a stream."""
        from .caller import STALL
        with self._client._pool.stream(request, call, STALL) as responses:
            head = next(responses)
            if head.status != 200:
                body = b"".join(block.body for block in responses)
                raise refusal(Response(head.status, head.headers, body), request)
            for data in events(response.body for response in responses):
                yield JobState.of(data)

    def __repr__(self) -> str:
        return f"<Job {self.id} {self.state.state} {self.state.percent} %>"


def events(blocks: Iterator[bytes]) -> Iterator[Dict[str, Any]]:
    """Yields the data of server-sent events (WHATWG HTML, section 9.2), one JSON object each; comments are skipped. Raises
    FractureError of type "damaged"."""
    text = bytearray()
    data: List[bytes] = []
    for block in blocks:
        text += block
        if len(text) > MOST_EVENT_BYTES:
            raise FractureError("damaged", f"An event of the job has more than {MOST_EVENT_BYTES:,} bytes.")
        if b"\n" not in block:
            continue
        *lines, rest = bytes(text).replace(b"\r\n", b"\n").split(b"\n")
        text = bytearray(rest)
        for line in lines:
            if line.startswith(b"data:"):
                data.append(line[5:].lstrip(b" "))
            elif not line and data:
                try:
                    document = json.loads(b"\n".join(data))
                except ValueError:
                    document = None
                if not isinstance(document, dict):
                    raise FractureError("damaged", "An event of the job is not a JSON object.")
                yield document
                data = []
