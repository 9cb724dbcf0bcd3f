"""summary.py FIGURES.json HEADERS FILE.glb: prints a short summary of one answer from the server."""
import json
import os
import sys

figures_path, headers_path, glb = sys.argv[1:]
with open(figures_path, encoding="utf-8") as f:
    certificate = json.load(f)["certificate"]
timing = ""
with open(headers_path, encoding="latin-1") as f:
    for line in f:
        if line.lower().startswith("server-timing:"):
            stages = [stage.strip().split(";dur=") for stage in line.split(":", 1)[1].split(",")]
            timing = ", ".join(f"{name} {float(ms):.1f} ms" for name, ms in stages)

number = lambda value: f"{value:.12g}"
print(f"   fragments   {certificate['fragments']} (open edges: {certificate['open_edges']})")
print(f"   volume in   {number(certificate['volume_in'])} m³")
print(f"   volume out  {number(certificate['volume_out'])} m³ (relative error {certificate['relative_error']:.1e})")
print(f"   timings     {timing}")
print(f"   wrote       {glb} ({os.path.getsize(glb)} bytes)")
