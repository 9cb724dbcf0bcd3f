#!/usr/bin/env python3
"""embed_openapi.py OPENAPI.yaml OUT.json OUT.cpp: writes the document as JSON, with the headers of components/headers in every
public response, and a C++ function that returns this JSON."""
import json
import sys

import yaml


def add_common_headers(document):
    """Adds the headers in components/headers to each response, because the public listener sends them with every response."""
    common = {name: {"$ref": f"#/components/headers/{name}"} for name in document["components"]["headers"]}
    for item in document["paths"].values():
        if "servers" in item:  # a path of the admin listener
            continue
        for operation in item.values():
            for response in operation.get("responses", {}).values() if isinstance(operation, dict) else ():
                if "$ref" in response:
                    response = document["components"]["responses"][response["$ref"].rsplit("/", 1)[1]]
                response["headers"] = {**response.get("headers", {}), **common}
    return document


source, as_json, out = sys.argv[1:]
with open(source, encoding="utf-8") as f:
    text = json.dumps(add_common_headers(yaml.safe_load(f)), indent=1, ensure_ascii=True)
with open(as_json, "w", encoding="ascii") as f:
    f.write(text)

# Some compilers limit the length of a string literal, so the text is split into adjacent literals of 8,000 characters.
pieces = "\n".join(f'R"openapi({text[i:i + 8000]})openapi"' for i in range(0, len(text), 8000))
with open(out, "w", encoding="ascii") as f:
    f.write('// Generated from proto/openapi.yaml.\n#include "server/http/api.hpp"\n\n')
    f.write("std::string_view fracture::http::openapi_json() {\n")
    f.write(f"  static constexpr std::string_view kDocument =\n{pieces};\n  return kDocument;\n}}\n")
