"""The names of all errors, and how this package reacts to each.

The name of a server error is the last segment of `type` in its problem document (RFC 9457). A test compares SERVER with the
interface description, so a new name fails the test until it is listed here.
"""
from __future__ import annotations

import enum
from typing import Dict


class Reaction(enum.Enum):
    """This package's reaction to an error, before the caller sees it."""

    RAISE = "none, because the same request would give the same error"
    WAIT = "wait for the time in Retry-After, then retry if the call has tries and time left"
    PUT = "send the forgotten mesh to the server once, and retry"
    REMAKE = "request the forgotten answer again, with its parameters instead of its address"


# Errors from the server. Statuses 429 and 503 mean that the server is busy; the other errors are about the request.
SERVER: Dict[str, Reaction] = {
    "bad-parameter": Reaction.RAISE,
    "unknown-parameter": Reaction.RAISE,
    "bad-json": Reaction.RAISE,
    "empty-body": Reaction.RAISE,
    "unknown-format": Reaction.RAISE,
    "malformed-mesh": Reaction.RAISE,
    "unsupported-feature": Reaction.RAISE,
    "external-resource": Reaction.RAISE,
    "importer-crashed": Reaction.RAISE,
    "importer-limit": Reaction.RAISE,
    "too-large": Reaction.RAISE,
    "empty-mesh": Reaction.RAISE,
    "not-finite": Reaction.RAISE,
    "mesh-not-closed": Reaction.RAISE,
    "too-complex": Reaction.RAISE,
    "no-fragments": Reaction.RAISE,
    "no-such-fragment": Reaction.RAISE,
    "no-such-answer": Reaction.REMAKE,
    "unsound": Reaction.RAISE,
    "cancelled": Reaction.WAIT,
    "deadline-exceeded": Reaction.RAISE,
    "job-lost": Reaction.RAISE,
    "out-of-memory": Reaction.WAIT,
    "internal": Reaction.RAISE,
    "malformed-request": Reaction.RAISE,
    "malformed-multipart": Reaction.RAISE,
    "malformed-coding": Reaction.RAISE,
    "content-digest-mismatch": Reaction.RAISE,
    "unauthorized": Reaction.RAISE,
    "forbidden": Reaction.RAISE,
    "not-found": Reaction.PUT,
    "method-not-allowed": Reaction.RAISE,
    "not-acceptable": Reaction.RAISE,
    "request-timeout": Reaction.RAISE,
    "precondition-failed": Reaction.RAISE,
    "body-too-large": Reaction.RAISE,
    "uri-too-long": Reaction.RAISE,
    "unsupported-coding": Reaction.RAISE,
    "unsupported-media-type": Reaction.RAISE,
    "range-not-satisfiable": Reaction.RAISE,
    "digest-mismatch": Reaction.RAISE,
    "expectation-failed": Reaction.RAISE,
    "too-many-connections": Reaction.WAIT,
    "over-share": Reaction.WAIT,
    "foreign-host": Reaction.RAISE,
    "foreign-origin": Reaction.RAISE,
    "header-too-large": Reaction.RAISE,
    "client-closed-request": Reaction.RAISE,
    "not-implemented": Reaction.RAISE,
    "overloaded": Reaction.WAIT,
    "draining": Reaction.WAIT,
    "version-not-supported": Reaction.RAISE,
}

# Errors from this client. They have no problem document, and most have no status.
LOCAL: Dict[str, str] = {
    "connection": "No server answers at this address, or the connection broke",
    "timeout": "The response did not arrive completely in time",
    "damaged": "The response is cut off, was changed in transit, or is not from a fracture server",
    "answer-too-large": "The answer is larger than this client accepts",
    "cancelled": "The call was cancelled, or the client is closed",
    "bad-url": "The server address is malformed",
    "bad-parameter": "A parameter cannot be sent",
}


def reaction_to(slug: str, status: int) -> Reaction:
    """Returns the reaction to an error with this name and status. If the name is unknown (from a newer server or a proxy), the
    status decides."""
    return SERVER.get(slug, Reaction.WAIT if status in (429, 503) else Reaction.RAISE)
