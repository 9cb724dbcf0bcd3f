"""The command line: one mesh, one answer."""
from __future__ import annotations

import argparse
import os
import pathlib
import sys
import urllib.parse
from typing import List, Optional, Tuple

from .answer import Answer, kind_of_file
from .client import Client
from .errors import FractureError
from .jobs import Job
from .version import VERSION

USAGE_LINE = "python -m fracture_client [options] SERVER MESH OUT [name=value ...]"
DESCRIPTION = "Breaks a mesh with a fracture server and writes the fragments."

EXAMPLES = """\
examples:
  python -m fracture_client http://127.0.0.1:8080 vase.glb shards.glb material=ceramic impacts=0.1,0.4,0.2
  python -m fracture_client http://127.0.0.1:8080 house.obj house.glb --job material=brick fragments=5000

exits with 0 done; 1 a file cannot be read or written, or the server does not answer; 2 wrong command line;
3 mesh or parameter refused; 4 the server failed; 130 interrupted"""

DONE, UNREACHABLE, USAGE, REFUSED, FAILED, INTERRUPTED = 0, 1, 2, 3, 4, 130
AWAY = ("connection", "timeout", "damaged", "answer-too-large", "cancelled")  # no word of the server's own


def main(arguments: List[str]) -> int:
    """Returns the exit code; prints to standard output what was made, and to standard error what went wrong."""
    parser = _parser()
    options = parser.parse_intermixed_args(arguments)
    query = _query(parser, options.parameters)
    try:
        kind_of_file(options.out)
    except FractureError as error:
        parser.error(error.detail)
    token = _token(parser, options.token_file)
    if not options.out.parent.is_dir():  # before a minute of work
        print(f"fracture_client: {options.out}: there is no folder {options.out.parent}", file=sys.stderr)
        return UNREACHABLE
    try:
        with Client(options.server, token, options.timeout) as client:
            mesh = client.put(options.mesh, files=options.file, format=options.format)
            for warning in mesh.report.get("warnings", []):
                _say(options.quiet, f"mesh: {warning}")
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
    for warning in answer.warnings:
        if warning not in mesh.report.get("warnings", []):
            _say(options.quiet, f"answer: {warning}")
    print(f"{options.out}: {_summary(answer)}, {options.out.stat().st_size} bytes")
    return DONE


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="fracture_client", usage=USAGE_LINE, description=DESCRIPTION, epilog=EXAMPLES,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("server", metavar="SERVER", help="its address: http://127.0.0.1:8080")
    parser.add_argument("mesh", metavar="MESH", type=pathlib.Path, help=".glb, .gltf, .obj, .stl, .ply, .off, or another format "
                        "that the server reads; what it names (.bin, .mtl, textures) is sent with it, from its folder and below")
    parser.add_argument("out", metavar="OUT", type=pathlib.Path, help=".glb or no ending, .gltf (one JSON text) or .json (the figures "
                        "alone)")
    parser.add_argument("parameters", metavar="name=value", nargs="*", default=[], help="any parameter of the interface, as a query has it: "
                        "material=stone fragments=40 seed=7 'impacts=0,0.5,0;0.2,1,0'; GET /patterns of the server lists them")
    parser.add_argument("--file", metavar="FILE", action="append", help="a further file of the mesh, repeated for more; then "
                        "none is looked for")
    parser.add_argument("--format", metavar="NAME", help="format of the mesh, where its ending does not say it")
    parser.add_argument("--job", action="store_true", help="as background work, which may take half an hour, with its progress")
    parser.add_argument("--token-file", metavar="FILE", type=pathlib.Path, help="the token is the first line of this file "
                        "(else of the variable FRACTURE_TOKEN, where it is set)")
    parser.add_argument("--timeout", metavar="SECONDS", type=_seconds, default=300.0, help="for each step (default: 300)")
    parser.add_argument("--quiet", action="store_true", help="no warnings and no progress")
    parser.add_argument("--version", action="version", version=VERSION)
    return parser


def _query(parser: argparse.ArgumentParser, words: List[str]) -> str:
    pairs: List[Tuple[str, str]] = []
    for word in words:
        name, equals, value = word.partition("=")
        if not equals or not name:
            parser.error(f"'{word}' is no parameter: they are written name=value, such as fragments=40")
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
        parser.error(f"--token-file {file} has no token in its first line")
    return lines[0].strip()


def _seconds(text: str) -> float:
    seconds = float(text)
    if not 0 < seconds < float("inf"):
        raise ValueError
    return seconds


def _followed(job: Job, quiet: bool) -> Answer:
    try:
        for state in job.progress():
            waiting = "" if state.queue_position is None else f", {state.queue_position} before it"
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
    return (f"{certificate['fragments']} fragments of {certificate['volume_out']:.6g} m³ together, "
            f"{certificate['open_edges']} open edges, algorithm {answer.algorithm}")
