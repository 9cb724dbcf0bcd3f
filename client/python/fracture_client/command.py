"""The command line: breaks a mesh and writes the result to a file."""
from __future__ import annotations

import argparse
import os
import pathlib
import sys
import urllib.parse
from typing import Any, List, Mapping, Optional, Tuple

from .answer import Answer, kind_of_file
from .client import Client
from .dropped import read_dropped
from .errors import FractureError
from .jobs import Job
from .version import VERSION

USAGE_LINE = "python -m fracture_client [options] SERVER MESH OUT [name=value ...]"
DESCRIPTION = "Breaks a mesh with a fracture server and writes the fragments."

EXAMPLES = """\
examples:
  python -m fracture_client http://127.0.0.1:8080 vase.glb shards.glb material=ceramic impacts=0.1,0.4,0.2
  python -m fracture_client http://127.0.0.1:8080 house.obj house.glb --job material=brick fragments=5000

exits with:
  0    done
  1    a file or standard output fails, the server does not answer, or the server is busy
  2    the command line is wrong
  3    the server refused the mesh or a parameter
  4    the server failed
  130  interrupted"""

DONE, UNREACHABLE, USAGE, REFUSED, FAILED, INTERRUPTED = 0, 1, 2, 3, 4, 130
AWAY = ("connection", "timeout", "damaged", "answer-too-large", "cancelled")  # errors without a valid answer from the server


def main(arguments: List[str]) -> int:
    """Runs the command and returns its exit code. Prints the result to standard output, and warnings, progress and errors to
    standard error."""
    parser = _parser()
    options = parser.parse_intermixed_args(arguments)
    query = _query(parser, options.parameters)
    try:
        kind_of_file(options.out)
    except FractureError as error:
        parser.error(error.detail)
    token = _token(parser, options.token_file)
    if not options.out.parent.is_dir():  # checked before the work, which may take a minute
        print(f"fracture_client: {options.out}: the folder {options.out.parent} does not exist. Create it, or choose another file.",
              file=sys.stderr)
        return UNREACHABLE
    try:
        with Client(options.server, token, options.timeout) as client:
            mesh = client.put(options.mesh, files=options.file, format=options.format)
            _say_remarks(options.quiet, "mesh", mesh.report, {})
            if options.job:
                answer = _followed(client.job(mesh, query), options.quiet)
            else:
                answer = mesh.fracture(query)
            answer.save(options.out)
    except FractureError as error:
        print(f"fracture_client: {error}", file=sys.stderr)
        if error.type == "bad-url":
            return USAGE
        if error.type in AWAY or error.status in (429, 503):
            return UNREACHABLE
        return FAILED if error.status >= 500 or error.type.startswith("http-") else REFUSED
    except OSError as error:
        print(f"fracture_client: {error.filename or options.out}: {error.strerror or error}", file=sys.stderr)
        return UNREACHABLE
    except KeyboardInterrupt:
        print("fracture_client: interrupted", file=sys.stderr)
        return INTERRUPTED
    _say_remarks(options.quiet, "answer", answer.report, mesh.report)
    return DONE if _print(f"{options.out}: {_summary(answer)}, {options.out.stat().st_size:,} bytes") else UNREACHABLE


def _print(line: str) -> bool:
    """Prints to standard output. Returns whether this worked. If it failed, prints the reason to standard error."""
    reason = "it is closed"
    try:
        print(line, flush=True)
        if sys.stdout is not None:
            return True
    except OSError as error:
        reason = error.strerror
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # Python flushes the rest at the end, and would fail again
    print(f"fracture_client: cannot write to standard output: {reason}", file=sys.stderr)
    return False


def _say_remarks(quiet: bool, of: str, report: Mapping[str, Any], said: Mapping[str, Any]) -> None:
    """Prints the warnings, notes and dropped items in `report`, except those that are also in `said`, a report that was printed
    before."""
    for kind, name in (("warnings", "warning"), ("notes", "note")):
        for sentence in report.get(kind, []):
            if sentence not in said.get(kind, []):
                _say(quiet, f"{of}: {name}: {sentence}")
    for entry in read_dropped(report):
        if entry not in read_dropped(said):
            _say(quiet, f"{of}: dropped: {entry}")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="fracture_client", usage=USAGE_LINE, description=DESCRIPTION, epilog=EXAMPLES,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("server", metavar="SERVER", help="address of the server, such as http://127.0.0.1:8080")
    parser.add_argument("mesh", metavar="MESH", type=pathlib.Path, help="file to break: .glb, .gltf, .obj, .stl, .ply, .off, or another "
                        "format that the server reads; referenced files (.bin, .mtl, textures) in its folder or a subfolder are "
                        "sent, too")
    parser.add_argument("out", metavar="OUT", type=pathlib.Path, help="file to write: .glb, .gltf (a single JSON document) or .json "
                        "(data without geometry); without an extension: GLB")
    parser.add_argument("parameters", metavar="name=value", nargs="*", default=[], help="parameters of the interface, such as "
                        "material=stone fragments=40 seed=7 'impacts=0,0.5,0;0.2,1,0'; GET /patterns lists them all")
    parser.add_argument("--file", metavar="FILE", action="append", help="an additional file to send with the mesh; can be repeated. "
                        "With this option, only these additional files are sent")
    parser.add_argument("--format", metavar="NAME", help="format of the mesh, if its file extension does not show it")
    parser.add_argument("--job", action="store_true", help="break the mesh in a background job, which may take up to half an "
                        "hour, and show progress")
    parser.add_argument("--token-file", metavar="FILE", type=pathlib.Path, help="file with the token in its first line "
                        "(default: the environment variable FRACTURE_TOKEN)")
    parser.add_argument("--timeout", metavar="SECONDS", type=_seconds, default=300.0, help="time limit for each step in seconds (default: 300)")
    parser.add_argument("--quiet", action="store_true", help="do not print warnings, notes or progress")
    parser.add_argument("--version", action="version", version=VERSION)
    return parser


def _query(parser: argparse.ArgumentParser, words: List[str]) -> str:
    pairs: List[Tuple[str, str]] = []
    for word in words:
        name, equals, value = word.partition("=")
        if not equals or not name:
            parser.error(f"'{word}' is not a parameter: write name=value, such as fragments=40")
        pairs.append((name, value))
    return urllib.parse.urlencode(pairs, quote_via=urllib.parse.quote, safe=",;:", encoding="utf-8", errors="surrogateescape")


def _token(parser: argparse.ArgumentParser, file: Optional[pathlib.Path]) -> Optional[str]:
    if file is None:
        return os.environ.get("FRACTURE_TOKEN") or None
    try:
        lines = file.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        parser.error(f"--token-file {file}: {getattr(error, 'strerror', None) or error}")
    if not lines or not lines[0].strip():
        parser.error(f"--token-file {file}: the first line is empty; put the token there")
    return lines[0].strip()


def _seconds(text: str) -> float:
    seconds = float(text)
    if not 0 < seconds < float("inf"):
        raise ValueError
    return seconds


def _followed(job: Job, quiet: bool) -> Answer:
    try:
        for state in job.progress():
            waiting = "" if state.queue_position is None else f", {state.queue_position} ahead in the queue"
            _say(quiet, f"job {state.id}: {state.state} {state.percent} % {state.stage}{waiting}".rstrip())
        return job.result()
    except KeyboardInterrupt:
        job.cancel(timeout=5)
        raise


def _say(quiet: bool, text: str) -> None:
    if not quiet:
        print(text, file=sys.stderr)


def _summary(answer: Answer) -> str:
    certificate = answer.certificate
    fragments, edges = certificate["fragments"], certificate["open_edges"]
    return (f"{fragments:,} fragment{'' if fragments == 1 else 's'}, {certificate['volume_out']:.6g} m³ in total, "
            f"{edges:,} open edge{'' if edges == 1 else 's'}, algorithm {answer.algorithm}")
