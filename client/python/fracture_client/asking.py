"""Sends a request until an answer arrives, or until the call has no tries or time left.

- If the server cannot be reached, it retries after increasingly long pauses.
- If the server is busy, it retries after the server's Retry-After.
- If the server has forgotten the mesh, it sends the mesh with PUT and retries.
- If an answer is cut off or its digest is wrong, it retries at once.

All requests can be repeated safely, because identical requests give identical bytes. client/protocol/client.hpp has the same rules.
"""
from __future__ import annotations

import base64
import hashlib
import json
import re
import time
from typing import Any, Callable, Dict, Optional

from .calls import Call
from .errors import FractureError
from .http1 import Request, Response, Trouble
from .pool import Pool, Settings
from .problems import Reaction, reaction_to

DONE = (200, 201, 202, 204, 206, 304)  # the server sends 304 and 206 only if the request asked for them
LONGEST_RETRY_AFTER = 86_400  # s; longer values are ignored
WRONG_DIGEST = "The bytes of the answer do not match its Repr-Digest: they were changed in transit."

# Returns what is wrong with a successful response; "" if nothing is.
Check = Callable[[Response], str]


def ask(pool: Pool, settings: Settings, request: Request, call: Call, check: Check,
        put: Optional[Callable[[float], bool]] = None) -> Response:
    """Sends the request and returns the answer. Raises FractureError.

    `put`: called if the server does not have the mesh, with the time at which the request was sent (time.monotonic()). It sends the
    mesh, once for all calls that need it, and returns whether to retry.
    """
    pause, damaged, tries = settings.first_pause, 0, 0
    while True:
        tries += 1
        sent = time.monotonic()
        wait = pause
        try:
            response = pool.exchange(request, call)
        except Trouble as trouble:
            cut = trouble.type == "connection" and trouble.began
            failure = FractureError("damaged" if cut else trouble.type, _detail(trouble, request, pool, time.monotonic() - sent))
            if not trouble.again:
                raise failure from None
            if failure.type == "damaged":
                damaged, wait = damaged + 1, 0.0
        else:
            if response.status in DONE:
                wrong = check(response)
                if not wrong:
                    return response
                failure = FractureError("damaged", wrong, status=response.status)
                damaged, wait = damaged + 1, 0.0
            else:
                failure = refusal(response, request)
                reaction = reaction_to(failure.type, response.status)
                if reaction is Reaction.WAIT:
                    after = retry_after(response)
                    wait = pause if after is None else after
                elif reaction is Reaction.PUT and response.status == 404 and put is not None and put(sent):
                    wait, tries = 0.0, tries - 1  # the server has the mesh now, so this was not a failed try
                else:
                    raise failure
        left = call.remaining()
        if damaged >= settings.damaged_answers or tries >= settings.tries or (left is not None and left <= wait):
            raise _with_tries(failure, tries) from None
        if wait > 0:
            call.pause(wait)
            pause = min(2 * pause, settings.longest_pause)


def _detail(trouble: Trouble, request: Request, pool: Pool, seconds: float) -> str:
    detail = trouble.detail
    if pool.address.authority not in detail:
        detail = f"{request.what} at {pool.address.authority}: {detail}"
    return f"{detail} ({seconds:.1f} s)" if trouble.type == "timeout" else detail


def _with_tries(failure: FractureError, tries: int) -> FractureError:
    if tries > 1:
        failure.detail += f" (asked {tries} times)"
    return failure


def refusal(response: Response, request: Request) -> FractureError:
    """Returns the error for a response whose status is not in DONE."""
    document = json_object(response.body)
    if document is not None and isinstance(document.get("type"), str) and document["type"].startswith("/problems/"):
        return FractureError.of_problem(document, response.status)
    said = re.sub(r"<[^>]*>", " ", response.body[:2000].decode("utf-8", "replace"))  # proxies send HTML pages
    said = " ".join(said.split())[:200]
    where = response.headers.get("location")
    detail = (f"{request.what}: the response (HTTP {response.status}) has no problem document from a fracture server. "
              "Check the address: a proxy or another server may be answering there.")
    if where:
        detail += f" It redirects to {where}."
    elif said:
        detail += f" Its text: {said}"
    return FractureError(f"http-{response.status}", detail, status=response.status,
                         title="The response is not from a fracture server", problem=document)


def retry_after(response: Response) -> Optional[float]:
    """Returns the seconds in Retry-After (RFC 9110, section 10.2.3); None if it is not a number (a date, for example) or exceeds a day."""
    text = response.headers.get("retry-after", "").strip()
    if not re.fullmatch(r"[0-9]{1,9}", text) or int(text) > LONGEST_RETRY_AFTER:
        return None
    return float(text)


def digest_matches(field: str, content: bytes) -> bool:
    """Returns whether a Repr-Digest field (RFC 9530) contains the SHA-256 of this content. False if it has no sha-256."""
    for entry in field.split(","):
        entry = entry.strip()
        if entry.startswith("sha-256="):
            wanted = base64.b64encode(hashlib.sha256(content).digest()).decode("ascii")
            return entry[len("sha-256="):] == f":{wanted}:"
    return False


def check_digest(response: Response) -> str:
    """Checks an answer with fragments against its digest. Returns what is wrong, or ""."""
    if response.status in (204, 206, 304):
        return ""  # the digest covers the whole answer, but this response has no body or only part of it
    field = response.headers.get("repr-digest", "")
    if not field:
        return "The answer has no Repr-Digest, so it cannot be checked."
    if not digest_matches(field, response.body):
        return WRONG_DIGEST
    return ""


def check_json(response: Response) -> str:
    """Checks that a response is a JSON object. Returns what is wrong, or ""."""
    if "repr-digest" in response.headers and not digest_matches(response.headers["repr-digest"], response.body):
        return WRONG_DIGEST
    return "" if json_object(response.body) is not None else "The response is not a JSON object."


def check_figures(response: Response) -> str:
    return check_digest(response) or check_json(response)


def check_digest_if_any(response: Response) -> str:
    return check_digest(response) if "repr-digest" in response.headers else ""


def check_nothing(response: Response) -> str:
    """Accepts every response. Used for text and empty responses."""
    return ""


def json_object(content: bytes) -> Optional[Dict[str, Any]]:
    try:
        document = json.loads(content)
    except (ValueError, RecursionError):
        return None
    return document if isinstance(document, dict) else None
