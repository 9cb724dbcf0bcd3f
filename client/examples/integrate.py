#!/usr/bin/env python3
"""What an engine has to do to break things with the service, in Python's standard library.

    integrate.py http://127.0.0.1:8080 barrel.glb out.glb '{"material": "wood", "impacts": [[0, 0.5, 0]]}'
"""
import base64, hashlib, http.client, json, struct, sys, time, urllib.parse


def ask(connection, method, path, body, content_type):
    """One exchange on the kept connection; a busy server is asked again when it says so."""
    while True:
        connection.request(method, path, body, {"Content-Type": content_type})
        answer = connection.getresponse()
        data = answer.read()
        if answer.status not in (429, 503):
            return answer, data
        time.sleep(int(answer.getheader("Retry-After", "1")))


server, mesh_file, out_file, parameters = sys.argv[1:5]
connection = http.client.HTTPConnection(urllib.parse.urlsplit(server).netloc, timeout=30)
mesh = open(mesh_file, "rb").read()
path = "/meshes/sha256:" + hashlib.sha256(mesh).hexdigest()
for attempt in range(2):  # at the collision: a few bytes; the mesh only where the server does not have it
    answer, glb = ask(connection, "POST", path + "/fracture", parameters, "application/json")
    if answer.status != 404 or attempt == 1:
        break
    stored, report = ask(connection, "PUT", path, mesh, "model/gltf-binary")
    if stored.status not in (200, 201):
        sys.exit(json.loads(report)["detail"])
if answer.status != 200:
    sys.exit(json.loads(glb)["detail"])
digest = base64.b64encode(hashlib.sha256(glb).digest()).decode()
assert answer.getheader("Repr-Digest") == f"sha-256=:{digest}:", "damaged on the way"
open(out_file, "wb").write(glb)
scene = json.loads(glb[20 : 20 + struct.unpack("<I", glb[12:16])[0]])
for node in scene["nodes"]:
    fragment = node.get("extras", {}).get("fracture", {})
    if "id" in fragment:
        motion = node["extensions"]["KHR_physics_rigid_bodies"]["motion"]
        print(fragment["id"], f"{motion['mass']:.3f} kg at", node.get("translation", [0, 0, 0]))
