"""The one exception of this package."""
from __future__ import annotations

from typing import Any, Dict, List, Optional

from . import problems


MOST_NAMES = 20  # of what there is, in a message; FractureError.problem has all


class FractureError(Exception):
    """What the server refuses, and what goes wrong on the way to it.

    type       what it is, for programs: "bad-parameter", "overloaded", "connection", … (problems.SERVER, problems.LOCAL;
               "http-502" and the like where somebody else than a fracture server answered)
    status     of the HTTP answer; 0 where there was none
    title      what the type means, for people
    detail     what was wrong this time, with the value and the limit
    parameter  the parameter that is concerned; "" where none is
    problem    the whole problem document (RFC 9457) as the server sent it; {} where none came
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
        """Of a problem document, also one that stands inside of another document (a job's `error`)."""
        kind = text_of(problem, "type").rsplit("/", 1)[-1]
        code = problem.get("status")
        status = status or (code if isinstance(code, int) else 0)
        title = text_of(problem, "title")
        detail = text_of(problem, "detail") or title or f"The server answered {status}."
        return cls(kind or f"http-{status}", detail, status=status, title=title,
                   parameter=text_of(problem, "parameter"), problem=problem)

    @property
    def details(self) -> List[str]:
        """One line for each thing that is wrong: a request may have several parameters that are."""
        errors = self.problem.get("errors")
        lines = [text_of(e, "detail") for e in errors if isinstance(e, dict)] if isinstance(errors, list) else []
        lines = [line.strip() for line in lines if line]
        more = self.problem.get("more_errors")
        if lines and isinstance(more, int) and more > 0:
            lines.append(f"{more} more are not listed.")
        known = self.problem.get("known")  # names that there are, where one was given that there is not
        if isinstance(known, list) and known:
            names = ", ".join(map(str, known[:MOST_NAMES])) + (", …" if len(known) > MOST_NAMES else "")
            return (lines or [self.detail]) + [f"There is: {names}."]
        return lines or [self.detail]

    def __str__(self) -> str:
        of = f"{self.type}, HTTP {self.status}" if self.status else self.type
        return "\n".join(self.details) + f" [{of}]"

    def __repr__(self) -> str:
        return f"FractureError(type={self.type!r}, status={self.status}, detail={self.detail!r})"

    def __reduce__(self) -> Any:  # exceptions are pickled by their arguments, of which there is one too few
        return (_restored, (self.type, self.detail, self.status, self.title, self.parameter, self.problem))


def _restored(type: str, detail: str, status: int, title: str, parameter: str, problem: Dict[str, Any]) -> FractureError:
    return FractureError(type, detail, status=status, title=title, parameter=parameter, problem=problem)


def text_of(document: Dict[str, Any], key: str) -> str:
    """The member, if it is text; else nothing."""
    value = document.get(key)
    return value if isinstance(value, str) else ""
