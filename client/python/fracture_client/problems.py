"""What may go wrong, by name, and what this package does about it.

The server names what is wrong by the last segment of the `type` of a problem document (RFC 9457). A test holds SERVER to
the interface description, so that a new name fails until it stands here.
"""
from __future__ import annotations

import enum
from typing import Dict


class Reaction(enum.Enum):
    """What is done before the caller hears of a problem."""

    RAISE = "nothing: asking the same again gives the same"
    WAIT = "asked again after Retry-After, as long as tries and time last"
    PUT = "a mesh that the server has forgotten is sent again, once"
    REMAKE = "an answer that the server has forgotten is asked for by its parameters"


# Of the server. Statuses 429 and 503 say that it is busy; the others are about the request.
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

# Of this side: no problem document came, so that these have no status.
LOCAL: Dict[str, str] = {
    "connection": "Nobody answers at this address, or the connection broke",
    "timeout": "There was no whole answer in time",
    "damaged": "What came is cut off, changed on its way, or no answer of a fracture server",
    "answer-too-large": "The answer is larger than this client takes",
    "cancelled": "The call was taken back, or the client is closed",
    "bad-url": "The address of the server is none",
    "bad-parameter": "A parameter cannot be sent",
}


def reaction_to(slug: str, status: int) -> Reaction:
    """Also for what a newer server, or a proxy before it, says."""
    return SERVER.get(slug, Reaction.WAIT if status in (429, 503) else Reaction.RAISE)
