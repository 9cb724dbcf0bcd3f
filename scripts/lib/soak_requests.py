"""The requests of scripts/soak. Some are repeated often enough to be found in caches, and some contain mistakes of every kind that a client
can make. Each request lists the statuses that the response may have."""
import gzip
import json
import random

NAMES = ("ana", "bob", "cyd")
TOO_MUCH = {503, 504}  # a busy server may always respond with 503 and Retry-After, or with 504 at the deadline
CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
QUADS = ((1, 4, 3, 2), (5, 6, 7, 8), (1, 2, 6, 5), (2, 3, 7, 6), (3, 4, 8, 7), (4, 1, 5, 8))
MATERIALS = ("glass", "wood", "concrete", "stone", "brick", "ceramic", "metal", "cast_iron", "ice", "plaster", "terracotta", "sandstone", "crystal")


def box(number):
    """Returns box `number` as an OBJ file with twelve triangles."""
    size = (1 + number % 7 / 4, 1 + number % 5 / 3, 1 + number % 11 / 8)
    lines = ["v " + " ".join(f"{c * s:g}" for c, s in zip(corner, size)) for corner in CORNERS]
    return ("\n".join(lines + ["f " + " ".join(map(str, quad)) for quad in QUADS]) + "\n").encode()


class Ask:
    """One request. `key`: requests with the same key get the same bytes if the responses have status 200."""

    def __init__(self, method, path, expected, body=None, kind=None, key=None, **headers):
        self.method, self.path, self.expected, self.body, self.key = method, path, expected, body, key
        self.headers = {name.replace("_", "-"): value for name, value in headers.items()}
        if kind:
            self.headers["Content-Type"] = kind
        self.leave = None  # "unread": disconnects after sending the request; "half": disconnects after half of the body


class Mixture:
    """For a given seed, request k is always the same, except for ids from earlier answers."""

    def __init__(self, seed, assets):
        self.seed, self.assets = seed, assets
        self.answers, self.meshes, self.jobs = [], [], []  # (name of the client that sent it, path); only the latest ones

    def remember(self, kept, name, path):
        kept.append((name, path))
        del kept[:-64]

    def request(self, k):
        """Returns (name, Ask) for request k."""
        rng = random.Random(self.seed * 1_000_003 + k)
        name = rng.choice(NAMES)
        kinds = ((44, self.fracture), (10, self.earlier), (6, self.packed), (6, self.stored), (5, self.upload),
                 (4, self.job), (4, self.poll), (8, self.wrong), (5, self.leaves), (5, self.page), (3, self.hit))
        make = rng.choices([kind for _, kind in kinds], [weight for weight, _ in kinds])[0]
        ask = make(rng, name)
        ask.headers.setdefault("Authorization", f"Bearer {name}-token-0123456789")
        return name, ask

    def mesh(self, rng):
        if self.assets and rng.random() < 0.02:
            return rng.choice(self.assets)
        number = int(rng.paretovariate(0.7)) % 3000  # a few boxes are requested very often, most of them rarely
        return f"box{number}", box(number), "model/obj"

    def query(self, rng):
        query = f"sites={rng.randrange(2, 40)}&seed={rng.randrange(3)}"
        if rng.random() < 0.2:
            query += "&material=" + rng.choice(MATERIALS)
        return query

    def fracture(self, rng, name):
        mesh, body, kind = self.mesh(rng)
        query = self.query(rng)
        accept = rng.choice(("model/gltf-binary", "model/gltf-binary", "application/json"))
        ask = Ask("POST", "/fracture?" + query, {200} | TOO_MUCH, body, kind, Accept=accept)
        if not mesh.startswith("box"):
            ask.expected |= {422}  # assets may be refused, because not all are solids
        if accept == "model/gltf-binary":
            ask.key = mesh + "?" + query
        if rng.random() < 0.2:
            ask.headers["Priority"] = f"u={rng.randrange(8)}"
        if rng.random() < 0.2:
            ask.headers["Accept-Encoding"] = rng.choice(("gzip", "zstd", "zstd;q=0.5, gzip", "identity", "br"))
        return ask

    def packed(self, rng, name):
        ask = self.fracture(rng, name)
        ask.body = gzip.compress(ask.body, 1)
        ask.headers["Content-Encoding"] = "gzip"
        return ask

    def earlier(self, rng, name):
        if not self.answers:
            return self.page(rng, name)
        owner, path = rng.choice(self.answers)
        ask = Ask(rng.choice(("GET", "HEAD")), path, {200, 206, 404} | TOO_MUCH,
                  Accept=rng.choice(("model/gltf-binary", "application/json")))
        if rng.random() < 0.7:
            ask.headers["Authorization"] = f"Bearer {owner}-token-0123456789"
        elif owner != name:
            ask.expected |= {403}
        if rng.random() < 0.3:
            ask.headers["Range"] = f"bytes={rng.randrange(50)}-{rng.randrange(50, 4000)}"
        return ask

    def upload(self, rng, name):
        _, body, kind = self.mesh(rng)
        return Ask("POST", "/meshes", {200, 201} | TOO_MUCH, body, kind)

    def stored(self, rng, name):
        if not self.meshes:
            return self.upload(rng, name)
        owner, path = rng.choice(self.meshes)
        what = rng.random()
        if what < 0.6:
            ask = Ask("POST", path + "/fracture", {200, 404} | TOO_MUCH,
                      json.dumps({"sites": rng.randrange(2, 30), "seed": rng.randrange(5)}).encode(), "application/json")
        else:
            ask = Ask("GET" if what < 0.9 else "DELETE", path, {200, 204, 404} | TOO_MUCH)
        if rng.random() < 0.8:
            ask.headers["Authorization"] = f"Bearer {owner}-token-0123456789"
        return ask

    def job(self, rng, name):
        _, body, kind = self.mesh(rng)
        return Ask("POST", f"/fracture?sites={rng.randrange(10, 300)}&seed={rng.randrange(50)}", {202, 429} | TOO_MUCH, body, kind,
                   Prefer="respond-async")

    def poll(self, rng, name):
        if not self.jobs:
            return self.job(rng, name)
        owner, path = rng.choice(self.jobs)
        ask = Ask("DELETE" if rng.random() < 0.2 else "GET", path, {200, 204, 303, 404} | TOO_MUCH)
        ask.headers["Authorization"] = f"Bearer {owner}-token-0123456789"
        if ask.method == "GET" and rng.random() < 0.3:
            ask.headers["Prefer"] = "wait=1"
        return ask

    def hit(self, rng, name):
        mine = [path for owner, path in self.answers if owner == name]
        if not mine:
            return self.fracture(rng, name)
        body = {"of": rng.choice(mine), "local_point": [round(rng.random(), 3) for _ in range(3)],
                "local_radius": 0.3, "local_sites": rng.randrange(2, 12)}
        return Ask("POST", "/fracture", {200, 400, 404, 409, 422} | TOO_MUCH, json.dumps(body).encode(), "application/json")

    def page(self, rng, name):
        return Ask("GET", rng.choice(("/version", "/limits", "/patterns", "/", "/problems/too-large", "/openapi.json", "/jobs")),
                   {200} | TOO_MUCH)

    def leaves(self, rng, name):
        ask = self.fracture(rng, name)
        ask.leave = rng.choice(("unread", "half"))
        return ask

    def wrong(self, rng, name):
        mesh = box(rng.randrange(50))
        bad = {400, 401, 404, 405, 406, 411, 413, 414, 415, 422, 431}
        garbage = bytes(rng.randrange(256) for _ in range(300))
        return rng.choice((
            lambda: Ask("POST", "/fracture?sites=-1", bad, mesh, "model/obj"),
            lambda: Ask("POST", "/fracture?site=5", bad, mesh, "model/obj"),
            lambda: Ask("POST", "/fracture?sites=5", bad, garbage, "model/obj"),
            lambda: Ask("POST", "/fracture?sites=5", bad, garbage, "model/gltf-binary"),
            lambda: Ask("POST", "/fracture?sites=5", bad, b"glTF" + garbage, "model/gltf-binary"),
            lambda: Ask("POST", "/fracture", bad, b'{"of": ' + garbage, "application/json"),
            lambda: Ask("POST", "/fracture?sites=5", bad, garbage, "model/obj", Content_Encoding="gzip"),
            lambda: Ask("POST", "/fracture?sites=5", bad, gzip.compress(mesh)[:-9], "model/obj", Content_Encoding="gzip"),
            lambda: Ask("POST", "/fracture?sites=5", bad, mesh, "text/html"),
            lambda: Ask("POST", "/fracture?sites=5", bad, b"", "model/obj"),
            lambda: Ask("POST", "/fracture?sites=5", bad, mesh, "model/obj", Authorization="Bearer nobody"),
            lambda: Ask("DELETE", "/limits", bad),
            lambda: Ask("GET", "/" + "a" * rng.randrange(5000), bad),
            lambda: Ask("GET", "/fractures/sha256:" + "0" * 64, bad),
            lambda: Ask("GET", "/jobs/none", bad),
            lambda: Ask("POST", "/fracture?sites=3", bad, mesh.replace(b"f 4 1 5 8", b"f 4 1 5 9"), "model/obj"),
            lambda: Ask("POST", "/fracture?sites=5", bad, mesh, "model/obj", Accept="image/png")))()
