#!/usr/bin/env python3
"""What an engine has to do to break things with the service, in Python's standard library.

    integrate.py http://127.0.0.1:8080 barrel.glb out.glb '{"material": "wood", "impacts": [[0, 0.5, 0]]}'
"""
import base64, hashlib, http.client, json, struct, sys, time, urllib.parse

server, mesh_file, out_file, parameters = sys.argv[1:5]
connection = http.client.HTTPConnection(urllib.parse.urlsplit(server).netloc, timeout=30)  # kept for all requests


def ask(method, path, body, content_type):
    while True:
        connection.request(method, path, body, {"Content-Type": content_type})
        answer = connection.getresponse()
        data = answer.read()
        if answer.status in (200, 201, 404):
            return answer, data
        if answer.status not in (429, 503):
            sys.exit(json.loads(data)["detail"])
        time.sleep(int(answer.getheader("Retry-After", "1")))  # busy: it says for how long


mesh = open(mesh_file, "rb").read()
path = "/meshes/sha256:" + hashlib.sha256(mesh).hexdigest()
answer, glb = ask("POST", path + "/fracture", parameters, "application/json")  # a few bytes at the collision
if answer.status == 404:  # the mesh itself when the level is loaded, and where the server has forgotten it
    ask("PUT", path, mesh, "model/gltf-binary")
    answer, glb = ask("POST", path + "/fracture", parameters, "application/json")
digest = base64.b64encode(hashlib.sha256(glb).digest()).decode()
assert answer.getheader("Repr-Digest") == f"sha-256=:{digest}:", "damaged on the way"
open(out_file, "wb").write(glb)
for node in json.loads(glb[20 : 20 + struct.unpack("<I", glb[12:16])[0]])["nodes"]:
    fragment = node.get("extras", {}).get("fracture", {})
    if "id" in fragment:
        motion = node["extensions"]["KHR_physics_rigid_bodies"]["motion"]
        print(fragment["id"], f"{motion['mass']:.3f} kg at", node.get("translation", [0, 0, 0]))
