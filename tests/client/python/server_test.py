#!/usr/bin/env python3
"""Every operation of the interface through the package, against the real server."""
import asyncio
import json
import math
import pathlib
import pickle
import tempfile
import threading
import unittest

from support import PATIENCE, Client, FractureError, Server, WithServer, box_obj, caught, eventually, main
from fracture_client import Admin, AsyncClient, Cancel, glb, problems


class Operations(WithServer):
    def test_discovery(self):
        self.assertEqual(self.client.version()["name"], "fracture-server")
        self.assertEqual(self.client.index()["algorithm"], self.client.version()["algorithm"])
        self.assertIn("glb", self.client.limits()["formats"])
        self.assertIn("stone", [material["name"] for material in self.client.patterns()["materials"]])
        self.assertIn("/fracture", self.client.openapi()["paths"])
        self.assertIn("bad-parameter", self.client.explain("bad-parameter"))
        self.assertEqual(caught(self.client.explain, "no-such-problem").type, "not-found")
        self.assertIn(b"POST /fracture", self.client.request("GET", "/llms.txt").body)

    def test_every_type_of_problem_has_its_page(self):
        for name in problems.SERVER:
            self.assertIn(name, self.client.explain(name))

    def test_the_admin_listener(self):
        with Admin(self.server.admin_url) as admin:
            self.assertTrue(admin.is_alive())
            self.assertTrue(admin.is_ready())
            self.assertIn("fracture_", admin.metrics())
        with Admin("http://127.0.0.1:1") as nobody:
            self.assertFalse(nobody.is_alive() or nobody.is_ready())

    def test_a_mesh_from_its_put_to_its_end(self):
        content = box_obj(1, 2, 3)
        mesh = self.client.put(content, format="obj")
        self.assertEqual(mesh.report["verdict"], "closed")
        self.assertEqual(mesh.report["solid"]["volume"], 6)
        self.assertEqual(self.client.put(content, format="obj").stored, mesh.stored)
        again = self.client.mesh(mesh.id)
        self.assertEqual(again.report, {})
        self.assertEqual(again.refresh(), mesh.stored)
        self.assertTrue(mesh.forget())
        self.assertFalse(mesh.forget())
        self.assertEqual(caught(again.fracture, sites=3).type, "not-found")
        self.assertEqual(mesh.fracture(sites=3).certificate["fragments"], 3)  # the file is available here, so it was sent again

    def test_an_estimate(self):
        mesh = self.client.put(box_obj(1, 2, 3), format="obj")
        said = mesh.estimate(fragments=20)
        self.assertTrue(said["fits"])
        self.assertEqual(said["fragments"], 20)
        made = mesh.fracture(fragments=20)
        self.assertLess(said["bytes"] / 2, len(made.glb))
        self.assertLess(len(made.glb), 2 * said["bytes"])
        self.assertEqual(caught(mesh.estimate, sites=0).type, "bad-parameter")

    def test_choices(self):
        mesh = self.client.put(box_obj(1000, 2000, 3000), format="obj")
        choice, = mesh.choices
        self.assertEqual((choice.kind, choice.parameters), ("unit", {"unit": "mm"}))
        answer = mesh.fracture(sites=2)
        self.assertEqual(answer.choices, mesh.choices)
        self.assertEqual(len(answer.warnings), 1)
        self.assertEqual(mesh.fracture({"sites": 2, **choice.parameters}).choices, [])

    def test_a_broken_box(self):
        answer = self.client.put(box_obj(1, 2, 3), format="obj").fracture(fragments=20, density=500, seed=4)
        self.assertEqual(answer.certificate["open_edges"], 0)
        self.assertAlmostEqual(math.fsum(f.volume for f in answer.fragments), 6, places=9)
        self.assertAlmostEqual(math.fsum(f.mass for f in answer.fragments), 3000, places=6)
        self.assertAlmostEqual(math.fsum(f.exterior_area for f in answer.fragments), 22, places=6)
        ids = {f.id for f in answer.fragments}
        self.assertEqual(len(ids), answer.certificate["fragments"])
        self.assertTrue(answer.bonds)
        for bond in answer.bonds:
            self.assertTrue({bond.a, bond.b} <= ids)
            self.assertAlmostEqual(math.hypot(*bond.normal), 1, places=6)
            self.assertGreater(bond.area, 0)
        for fragment in answer.fragments:
            inside = signed_volume(fragment.positions, [p.indices for p in fragment.primitives])
            self.assertAlmostEqual(inside, fragment.volume, places=6)
            hull, = fragment.hulls
            self.assertTrue(0.9 * fragment.volume < signed_volume(hull.points, [hull.triangles]) < 1.000001 * fragment.volume)
            self.assertEqual({p.interior for p in fragment.primitives}, {True, False} if fragment.exterior_area else {True})
            for corner in fragment.hulls[0].points.tolist():  # hulls are inside the box of their fragment
                low, high = (pick(*zip(*fragment.positions.tolist())) for pick in (lows, highs))
                self.assertTrue(all(a - 1e-6 <= c <= b + 1e-6 for a, c, b in zip(low, corner, high)))
        self.assertGreater(answer.timing["work"], 0)
        self.assertEqual(answer.algorithm, self.client.version()["algorithm"])
        self.assertEqual(answer.parameters["seed"], 4)

    def test_physics_of_every_kind_is_read(self):
        mesh = self.client.put(box_obj(), format="obj")
        for physics, hulls, inertia in (("khr", True, True), ("omi", True, False), ("none", False, False)):
            for fragment in mesh.fracture(sites=6, physics=physics).fragments:
                self.assertEqual((bool(fragment.hulls), fragment.inertia_diagonal is not None), (hulls, inertia), physics)
                self.assertGreater(fragment.mass, 0)
        for fragment in mesh.fracture(sites=6, physics="none", ue_collision="ucx").fragments:
            self.assertEqual(len(fragment.hulls), 1)

    def test_one_request_for_mesh_and_parameters(self):
        content = box_obj(0.5, 0.5, 0.5)
        once = self.client.fracture(content, {"sites": 9}, format="obj", seed=2)
        self.assertEqual(once.glb, self.client.put(content, format="obj").fracture(sites=9, seed=2).glb)
        self.assertEqual(once.glb, self.client.fracture(content, "sites=9&seed=2", format="obj").glb)
        self.assertEqual(once.glb, self.client.fracture(once.mesh, sites=9, seed=2).glb)
        self.assertGreater(once.hit((0.25, 0.25, 0.25), 0.1).certificate["fragments"], 9)

    def test_thousands_of_points_are_parameters_too(self):
        points = [((k * 7919 % 1000) / 1000, (k * 104729 % 997) / 997, (k * 1299709 % 991) / 991) for k in range(1, 301)]
        answer = self.client.put(box_obj(), format="obj").fracture(pattern="points", points=points)
        self.assertEqual(answer.certificate["sites_asked"], 300)

    def test_figures_without_the_geometry(self):
        mesh = self.client.put(box_obj(), format="obj")
        self.assertEqual(mesh.figures(sites=7), mesh.fracture(sites=7).figures)

    def test_an_answer_again_by_its_address(self):
        answer = self.client.put(box_obj(), format="obj").fracture(sites=8)
        again = self.client.answer(answer.location)
        self.assertEqual((again.glb, again.location, again.mesh.id), (answer.glb, answer.location, answer.mesh.id))
        self.assertIsNone(self.client.answer(answer.location, unless=answer.etag))
        self.assertIsNotNone(self.client.answer(answer.location, unless='"other"'))
        self.assertEqual(caught(self.client.answer, "/fractures/sha256:" + "0" * 64).type, "not-found")
        self.assertTrue(again.hit((0.5, 0.5, 0.5), 0.2).delta.new)

    def test_whatever_else_the_interface_has(self):
        answer = self.client.put(box_obj(), format="obj").fracture(sites=8)
        part = self.client.request("GET", answer.location, headers={"Range": "bytes=0-3"})
        self.assertEqual((part.status, part.body), (206, b"glTF"))
        head = self.client.request("HEAD", answer.location)
        self.assertEqual((head.body, head.headers["content-length"]), (b"", str(len(answer.glb))))
        self.assertEqual(caught(self.client.request, "GET", answer.location, headers={"Range": "bytes=99999999-"}).type,
                         "range-not-satisfiable")
        self.assertEqual(caught(self.client.request, "GET", answer.location, headers={"If-Match": '"x"'}).type, "precondition-failed")
        self.assertEqual(caught(self.client.request, "GET", answer.location, headers={"Accept": "text/css"}).type, "not-acceptable")
        self.assertEqual(caught(self.client.request, "POST", "/version").type, "method-not-allowed")
        text = self.client.request("POST", f"/meshes/{answer.mesh.id}/fracture?sites=8", headers={"Accept": "model/gltf+json"})
        self.assertEqual(json.loads(text.body)["nodes"], glb.Glb(answer.glb).document["nodes"])

    def test_inspect(self):
        report = self.client.inspect(box_obj(100, 100, 100), format="obj", unit="cm")
        self.assertEqual((report["verdict"], report["frame"]["metres_per_unit"]), ("closed", 0.01))
        self.assertAlmostEqual(report["solid"]["volume"], 1, places=6)
        open_box = b"\n".join(line for line in box_obj().splitlines() if line != b"f 1 2 4 3")
        self.assertEqual(self.client.inspect(open_box, format="obj")["verdict"], "repaired")
        self.assertEqual(caught(self.client.inspect, open_box, format="obj", repair="strict").type, "mesh-not-closed")

    def test_what_a_mesh_is_prepared_with_holds_for_its_fractures(self):
        mesh = self.client.put(box_obj(100, 100, 100), format="obj", unit="cm", material="stone")
        self.assertAlmostEqual(mesh.report["solid"]["volume"], 1, places=6)
        first = mesh.fracture(sites=5)
        self.assertEqual((first.parameters["unit"], first.parameters["material"]), ("cm", "stone"))
        self.assertAlmostEqual(first.certificate["volume_out"], 1, places=6)
        self.assertEqual(mesh.fracture("sites=5").glb, first.glb)
        self.assertEqual(mesh.fracture("sites=5&unit=m").parameters["unit"], "m")
        self.assertEqual(mesh.fracture(sites=5, unit="m").parameters["unit"], "m")
        self.assertNotIn("material", mesh.fracture(sites=5, material=None).parameters)
        self.assertTrue(first.hit((0.5, 0.5, 0.5), 0.2).delta.new)  # the hit must not repeat material=None

    def test_refusals_name_every_parameter(self):
        mesh = self.client.put(box_obj(), format="obj")
        error = caught(mesh.fracture, sites=0, material="chocolate", sitess=4)
        self.assertEqual((error.type, error.status, error.title), ("bad-parameter", 400, error.problem["title"]))
        self.assertGreaterEqual(len(error.details), 2)
        self.assertIn("chocolate", str(error))
        self.assertEqual(caught(mesh.fracture, sitess=4).type, "unknown-parameter")
        for name in caught(mesh.fracture, nodes=["lid"]).problem["known"]:
            self.assertIn(name, str(caught(mesh.fracture, nodes=["lid"])))
        restored = pickle.loads(pickle.dumps(error))
        self.assertEqual((restored.type, str(restored), restored.problem), (error.type, str(error), error.problem))

    def test_numpy_values_are_parameters(self):
        try:
            import numpy
        except ImportError:
            self.skipTest("numpy is not installed")
        mesh = self.client.put(box_obj(), format="obj")
        answer = mesh.fracture(pattern="impact", impacts=numpy.array([[0.5, 0.5, 0.5]]), sites=numpy.int64(9),
                               radius=numpy.float32(0.25))
        self.assertEqual(answer.glb, mesh.fracture(pattern="impact", impacts=[[0.5, 0.5, 0.5]], sites=9, radius=0.25).glb)
        self.assertEqual(answer.fragments[0].positions.dtype, numpy.float32)

    def test_the_same_for_asyncio(self):
        async def run():
            async with AsyncClient(self.server.url) as client:
                mesh = await client.put(box_obj(), format="obj")
                self.assertEqual((await mesh.refresh())["id"], mesh.id)
                answers = await asyncio.gather(*(mesh.fracture(sites=5, seed=seed) for seed in range(6)))
                self.assertEqual({a.certificate["fragments"] for a in answers}, {5})
                hit = await answers[0].hit((0.5, 0.5, 0.5), 0.3)
                self.assertEqual(hit.glb, self.client.put(box_obj(), format="obj").fracture(sites=5, seed=0).hit((0.5, 0.5, 0.5), 0.3).glb)
                self.assertTrue((await hit.hit((0.4, 0.5, 0.5), 0.1)).delta.new)
                self.assertEqual(await mesh.figures(sites=5, seed=0), answers[0].figures)
                self.assertEqual((await client.fracture(mesh, sites=5, seed=0)).glb, answers[0].glb)
                self.assertEqual((await client.answer(answers[0].location)).glb, answers[0].glb)
                self.assertEqual((await client.inspect(box_obj(), format="obj"))["verdict"], "closed")
                for discover in (client.index, client.version, client.limits, client.patterns, client.openapi):
                    self.assertTrue(await discover())
                self.assertIn("draining", await client.explain("draining"))
                self.assertEqual((await client.request("GET", "/version")).status, 200)
                self.assertEqual(client.mesh(mesh.id).report, {})
                with self.assertRaises(FractureError):
                    await mesh.fracture(sites=0)
                self.assertTrue(await mesh.forget())
        asyncio.run(run())


class Stopping(unittest.TestCase):
    def test_a_cancelled_call_frees_the_server(self):
        server = Server("--deadline", "36000")  # otherwise long requests would be refused
        self.addCleanup(server.stop)
        with Client(server.url) as client, Admin(server.admin_url) as admin:
            mesh = client.put(box_obj(), format="obj")
            for end in ("token", "deadline", "close"):
                asking = Client(server.url)
                token = Cancel()
                before = admin.metrics()
                errors = []
                options = {"cancel": token, "timeout": 3.0 if end == "deadline" else None}
                request = threading.Thread(target=lambda: errors.append(
                    caught(asking.mesh(mesh.id).fracture, sites=20_000, lloyd=50, **options)))  # a minute on one thread
                request.start()
                eventually("the computation", lambda: figure(admin.metrics(), "fracture_flights") == 1 or errors)
                if end == "token":
                    token.cancel()
                elif end == "close":
                    asking.close()
                request.join(PATIENCE)
                self.assertEqual([error.type for error in errors], ["timeout" if end == "deadline" else "cancelled"])
                eventually("the server to stop computing", lambda: figure(admin.metrics(), "fracture_flights") == 0)
                self.assertEqual(figure(admin.metrics(), "fracture_work_abandoned_total"),
                                 figure(before, "fracture_work_abandoned_total") + 1)
                asking.close()
            self.assertEqual(mesh.fracture(sites=3).certificate["fragments"], 3)

    def test_a_server_that_starts_again_gets_its_mesh_again(self):
        first = Server()
        with Client(first.url, timeout=PATIENCE) as client:
            mesh = client.put(box_obj(), format="obj")
            before = mesh.fracture(sites=5)
            first.stop()
            self.assertEqual(caught(mesh.fracture, sites=5, timeout=0.3).type, "connection")
            second = Server(port=first.port)
            self.addCleanup(second.stop)
            self.assertEqual(mesh.fracture(sites=5).glb, before.glb)
            after = before.hit((0.5, 0.5, 0.5), 0.3)  # on an answer that only the client still has
            self.assertEqual(after.glb, mesh.fracture(sites=5).hit((0.5, 0.5, 0.5), 0.3).glb)


def figure(metrics, name):
    """Returns the value of a metric without labels."""
    return float(next(line.split()[1] for line in metrics.splitlines() if line.startswith(name + " ")))


class Tokens(unittest.TestCase):
    def test_a_token_opens_a_server_that_asks_for_one(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "tokens"
            file.write_text("studio s3cr3t-token-of-some-length\nviewer another-token-of-some-length read-only\n")
            server = Server("--token-file", str(file))
            self.addCleanup(server.stop)
            with Client(server.url) as nobody, Client(server.url, "wrong-token-of-some-length") as stranger:
                for client in (nobody, stranger):
                    error = caught(client.version)
                    self.assertEqual((error.type, error.status), ("unauthorized", 401))
            with Client(server.url, "another-token-of-some-length") as viewer:
                self.assertEqual(viewer.version()["name"], "fracture-server")
                self.assertEqual(caught(viewer.put, box_obj(), format="obj").type, "forbidden")
            with Client(server.url, "s3cr3t-token-of-some-length") as studio:
                self.assertEqual(studio.put(box_obj(), format="obj").fracture(sites=3).certificate["fragments"], 3)


def signed_volume(positions, indices):
    """The volume by the divergence theorem, over triangles that are counter-clockwise seen from outside."""
    corners = positions.tolist()
    return math.fsum(determinant(*(corners[v] for v in triangle)) / 6 for part in indices for triangle in part.tolist())


def determinant(a, b, c):
    return (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]))


def lows(*columns):
    return [min(column) for column in columns]


def highs(*columns):
    return [max(column) for column in columns]


if __name__ == "__main__":
    main()
