#!/usr/bin/env python3
"""embed_openapi.py OPENAPI.yaml OUT.cpp: the document as a C++ function that returns its JSON."""
import json
import sys

import yaml

source, out = sys.argv[1:]
with open(source, encoding="utf-8") as f:
    text = json.dumps(yaml.safe_load(f), indent=1, ensure_ascii=True)

# String literals have a length limit in some compilers: pieces of 8,000 characters are joined by the compiler.
pieces = "\n".join(f'R"openapi({text[i:i + 8000]})openapi"' for i in range(0, len(text), 8000))
with open(out, "w", encoding="ascii") as f:
    f.write('// Generated from proto/openapi.yaml.\n#include "server/http/api.hpp"\n\n')
    f.write("std::string_view fracture::http::openapi_json() {\n")
    f.write(f"  static constexpr std::string_view kDocument =\n{pieces};\n  return kDocument;\n}}\n")
