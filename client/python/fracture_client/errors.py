"""The exception of this package."""
from __future__ import annotations

from typing import Any, Dict, List, Optional

from . import problems


MOST_NAMES = 20  # maximum number of known names in a message; FractureError.problem has all of them


class FractureError(Exception):
    """The server refused the request, or no valid response arrived.

    type       name of the error for programs: "bad-parameter", "overloaded", "connection", … (problems.SERVER, problems.LOCAL);
               names such as "http-502" if the response came from a proxy or another server
    status     status of the HTTP response; 0 if there is no response
    title      the meaning of the type
    detail     what was wrong with this request, including the wrong value and the limit
    parameter  the name of the wrong parameter; "" if the error is not about a parameter
    problem    the server's whole problem document (RFC 9457); {} if there is none
    """

    def __init__(self, type: str, detail: str, *, status: int = 0, title: Optional[str] = None, parameter: str = "",
                 problem: Optional[Dict[str, Any]] = None) -> None:
        super().__init__(detail)
        self.type = type
        self.status = status
        self.title = problems.LOCAL.get(type, "") if title is None else title
        self.detail = detail
        self.parameter = parameter
        self.problem: Dict[str, Any] = {} if problem is None else problem

    @classmethod
    def of_problem(cls, problem: Dict[str, Any], status: int = 0) -> "FractureError":
        """Returns the error that a problem document describes. The document may be part of another one (a job's `error`)."""
        kind = text_of(problem, "type").rsplit("/", 1)[-1]
        code = problem.get("status")
        status = status or (code if isinstance(code, int) else 0)
        title = text_of(problem, "title")
        detail = text_of(problem, "detail") or title or f"The server answered HTTP {status} without a description."
        return cls(kind or f"http-{status}", detail, status=status, title=title,
                   parameter=text_of(problem, "parameter"), problem=problem)

    @property
    def details(self) -> List[str]:
        """The texts of all errors, because several parameters of a request can be wrong."""
        errors = self.problem.get("errors")
        lines = [text_of(e, "detail") for e in errors if isinstance(e, dict)] if isinstance(errors, list) else []
        lines = [line.strip() for line in lines if line]
        more = self.problem.get("more_errors")
        if lines and isinstance(more, int) and more > 0:
            lines.append("1 more error is not listed." if more == 1 else f"{more:,} more errors are not listed.")
        known = self.problem.get("known")  # the names that exist, if the request used one that does not
        if isinstance(known, list) and known:
            names = ", ".join(map(str, known[:MOST_NAMES])) + (", …" if len(known) > MOST_NAMES else "")
            return (lines or [self.detail]) + [f"Known names: {names}."]
        return lines or [self.detail]

    def __str__(self) -> str:
        of = f"{self.type}, HTTP {self.status}" if self.status else self.type
        return "\n".join(self.details) + f" [{of}]"

    def __repr__(self) -> str:
        return f"FractureError(type={self.type!r}, status={self.status}, detail={self.detail!r})"

    def __reduce__(self) -> Any:  # the default pickles only the arguments of Exception, which lack the type
        return (_restored, (self.type, self.detail, self.status, self.title, self.parameter, self.problem))


def _restored(type: str, detail: str, status: int, title: str, parameter: str, problem: Dict[str, Any]) -> FractureError:
    return FractureError(type, detail, status=status, title=title, parameter=parameter, problem=problem)


def text_of(document: Dict[str, Any], key: str) -> str:
    """Returns the document's member `key` if it is a string, else ""."""
    value = document.get(key)
    return value if isinstance(value, str) else ""
