#!/usr/bin/env python3
"""embed_llms.py PROTO_FOLDER OUT.cpp: writes a C++ function that returns the text of /llms.txt.

The text joins interface.md, the operations of openapi.yaml, parameters.md and materials.md. It is enough to write a client."""
import pathlib
import re
import sys

import yaml

SUMMARY = """# fracture-server

> POST a mesh and get its exact, watertight Voronoi fragments as one GLB with hulls, masses and bonds. The same request gives the
> same bytes. This file describes the whole interface.

The smallest request:

    curl --fail-with-body -T mesh.glb -X POST -H 'Content-Type: model/gltf-binary' \\
         'http://SERVER/fracture?material=stone&fragments=40&seed=1' -o fragments.glb

Programs can read the same information from `GET /openapi.json` (every status and header), `GET /limits` and `GET /patterns`.
"""


def plain(text):
    """Returns the text without pictures and comments. Links to files of the repository become plain text, because the text
    is served without these files."""
    text = re.sub(r"<!--.*?-->\n*", "", text, flags=re.S)
    text = re.sub(r"!\[[^\]]*\]\([^)]*\)", "", text)
    text = re.sub(r"\[([^\]]*)\]\((?!https?:)[^)]*\)", r"\1", text)
    return re.sub(r"^\| +\|", "|", text, flags=re.M)  # empty cells where pictures were


def operations(document):
    lines = ["# Every operation", ""]
    for path, item in document["paths"].items():
        for method, operation in item.items():
            if method in ("get", "put", "post", "delete"):
                where = " (admin listener)" if "servers" in item else ""
                statuses = ", ".join(str(status) for status in operation["responses"] if status != "default")
                lines.append(f"- `{method.upper()} {path}`{where}: {operation['summary']}. {statuses}")
    problems = document["components"]["schemas"]["Problem"]["properties"]["type"]["enum"]
    return "\n".join([*lines, "", "Any operation may return one of these problems: " + ", ".join(f"`{p}`" for p in problems) + "."])


proto, out = pathlib.Path(sys.argv[1]), sys.argv[2]
parts = [SUMMARY, plain((proto / "interface.md").read_text(encoding="utf-8")),
         operations(yaml.safe_load((proto / "openapi.yaml").read_text(encoding="utf-8"))),
         plain((proto / "parameters.md").read_text(encoding="utf-8")), plain((proto / "materials.md").read_text(encoding="utf-8"))]
text = "\n\n".join(part.strip("\n") for part in parts) + "\n"

# Some compilers limit the length of a string literal, so the text is split into adjacent literals.
pieces = "\n".join(f'R"llms({text[i:i + 4000]})llms"' for i in range(0, len(text), 4000))
with open(out, "w", encoding="utf-8") as f:
    f.write('// Generated from proto/.\n#include "server/http/api.hpp"\n\n')
    f.write(f"std::string_view fracture::http::llms_txt() {{\n  static constexpr std::string_view kText =\n{pieces};\n  return kText;\n}}\n")
