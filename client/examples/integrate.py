#!/usr/bin/env python3
"""How an engine breaks objects with the service: store the mesh once, send a request on a collision, read the fragments.

    integrate.py http://127.0.0.1:8080 barrel.glb out.glb '{"material": "wood", "impacts": [[0, 0.5, 0]]}'
"""
import json
import pathlib
import sys

# The example runs from a checkout in which the package is not installed.
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "python"))
from fracture_client import Client, FractureError  # noqa: E402

if len(sys.argv) not in (4, 5):
    sys.exit(__doc__)
server, mesh_file, out_file, *parameters = sys.argv[1:]
try:
    with Client(server) as client:
        mesh = client.put(mesh_file)  # when the level is loaded: sent only if the server does not have it yet
        answer = mesh.fracture(json.loads(parameters[0]) if parameters else {})  # at the collision: a few bytes
        answer.save(out_file)
except (FractureError, OSError, ValueError) as error:
    sys.exit(f"integrate.py: {error}")
for fragment in answer.fragments:  # each fragment is a separate body; answer.bonds says which fragments hold together
    print(fragment.id, f"{fragment.mass:.3f} kg at", list(fragment.translation))
