#!/usr/bin/env python3
"""Compares proto/openapi.yaml with the package. Every operation, status, problem type and job state has its place here,
and a new one fails until it is added."""
import ast
import copy
import inspect
import re
import unittest

from support import PACKAGE, ROOT, main
import fracture_client
from fracture_client import jobs, problems, upload
from fracture_client.problems import Reaction

try:
    import yaml
except ImportError:
    yaml = None

ELSE = "Client.request"  # happens only after a header that the caller sets
ERROR = "FractureError"

# For each operation: where it is in the package, and what each of its statuses becomes.
PLACES = {
    "getIndex": (["Client.index"], {"200": "dict", "304": ELSE}),
    "getDocs": ([ELSE], {"200": ELSE, "304": ELSE}),  # for browsers, like the next one
    "getPageFile": ([ELSE], {"200": ELSE, "304": ELSE}),
    "getVersion": (["Client.version"], {"200": "dict"}),
    "getLimits": (["Client.limits"], {"200": "dict"}),
    "getPatterns": (["Client.patterns"], {"200": "dict"}),
    "getOpenapi": (["Client.openapi"], {"200": "dict"}),
    "getLlms": ([ELSE], {"200": ELSE}),
    "getProblem": (["Client.explain"], {"200": "str"}),
    "postFracture": (["Client.fracture"], {"200": "Answer", "202": "Job", "400": ERROR, "406": ERROR, "408": ERROR, "413": ERROR,
                                           "415": ERROR, "422": ERROR, "503": ERROR, "504": ERROR}),
    "getFracture": (["Client.answer"], {"200": "Answer", "206": ELSE, "304": "None", "404": ERROR, "406": ERROR, "412": ERROR,
                                        "416": ERROR}),
    "postMesh": (["Client.inspect"], {"200": "dict", "201": "dict", "413": ERROR, "422": ERROR, "503": ERROR}),
    "putMesh": (["Client.put"], {"200": "Mesh", "201": "Mesh", "413": ERROR, "422": ERROR, "503": ERROR}),
    "getMesh": (["Client.put", "Mesh.refresh"], {"200": "Mesh", "404": ERROR}),
    "deleteMesh": (["Mesh.forget"], {"204": "bool", "404": "bool"}),
    "postMeshFracture": (["Mesh.fracture", "Mesh.figures", "Mesh.job", "Client.job", "Answer.hit"],
                         {"200": "Answer", "202": "Job", "400": ERROR, "404": ERROR, "503": ERROR, "504": ERROR}),
    "postMeshEstimate": (["Mesh.estimate"], {"200": "dict", "400": ERROR, "404": ERROR, "503": ERROR}),
    "getJobs": (["Client.jobs"], {"200": "Job", "400": ERROR}),
    "getJob": (["Client.find_job", "Job.refresh", "Job.wait", "Job.result"], {"200": "JobState", "404": ERROR, "503": ERROR}),
    "deleteJob": (["Job.cancel"], {"204": "bool", "404": "bool", "503": ERROR}),
    "getJobEvents": (["Job.progress"], {"200": "JobState", "404": ERROR, "503": ERROR}),
    "getLivez": (["Admin.is_alive"], {"200": "bool"}),
    "getReadyz": (["Admin.is_ready"], {"200": "bool", "503": "bool"}),
    "getMetrics": (["Admin.metrics"], {"200": "str"}),
}
RESULTS = {"dict", "str", "bool", "None", "Answer", "Mesh", "Job", "JobState", ERROR, ELSE}
METHODS = ("get", "put", "post", "delete", "patch", "head", "options", "trace")


def interface():
    return yaml.safe_load((ROOT / "proto" / "openapi.yaml").read_text(encoding="utf-8"))


def offences(document):
    """Returns what the document contains but the package lacks, and the reverse."""
    found = []
    operations = {}
    for path, item in document["paths"].items():
        for method in METHODS:
            if method in item:
                operations[item[method]["operationId"]] = (f"{method.upper()} {path}", item[method])
    for name in sorted(operations.keys() - PLACES.keys()):
        found.append(f"{operations[name][0]} ({name}) has no place in the package")
    for name in sorted(PLACES.keys() - operations.keys()):
        found.append(f"{name} is no longer an operation of the interface")
    for name in sorted(operations.keys() & PLACES.keys()):
        documented = set(map(str, operations[name][1]["responses"])) - {"default"}
        for status in sorted(documented ^ PLACES[name][1].keys()):
            found.append(f"{name}: the status {status} stands on one side alone")
    schemas = document["components"]["schemas"]
    types = {kind.rsplit("/", 1)[-1] for kind in schemas["Problem"]["properties"]["type"]["enum"]}
    found += [f"the problem {slug} stands on one side alone" for slug in sorted(types ^ problems.SERVER.keys())]
    states = set(schemas["JobState"]["enum"])
    found += [f"the state {state} of a job stands on one side alone" for state in sorted(states ^ set(jobs.STATES))]
    fields = set(schemas["Job"]["properties"]) - {"links"}
    found += [f"the member {name} of a job has no place in JobState" for name in sorted(fields - set(vars(jobs.JobState)["__annotations__"]))]
    return found


def media_types(content):
    return {kind for kind in content if kind.startswith("model/")}


@unittest.skipUnless(yaml, "PyYAML is not installed (python3-yaml)")
class Contract(unittest.TestCase):
    def test_everything_has_its_place(self):
        self.assertEqual(offences(interface()), [])

    def test_what_is_new_fails_until_it_has_one(self):
        def put(value, *path):
            def change(document):
                for key in path[:-1]:
                    document = document[key]
                document[path[-1]] = value
            return change
        operation = {"operationId": "getTea", "responses": {"200": {}}}
        problem = ("components", "schemas", "Problem", "properties", "type", "enum")
        for change, said in ((put({"get": operation}, "paths", "/tea"), "GET /tea"),
                             (put(operation, "paths", "/version", "delete"), "DELETE /version"),
                             (put({}, "paths", "/version", "get", "responses", "418"), "getVersion: the status 418"),
                             (put(["/problems/tea"], *problem), "the problem tea"),
                             (put(["queued", "steeping"], "components", "schemas", "JobState", "enum"), "steeping"),
                             (put({}, "components", "schemas", "Job", "properties", "tea"), "the member tea"),
                             (lambda document: document["paths"].pop("/limits"), "getLimits is no longer an operation")):
            document = copy.deepcopy(interface())
            change(document)
            self.assertTrue(any(said in offence for offence in offences(document)), said)

    def test_places_are_there_also_for_asyncio(self):
        for places, statuses in PLACES.values():
            self.assertLessEqual(set(statuses.values()), RESULTS)
            for place in places:
                owner, method = place.split(".")
                self.assertTrue(callable(getattr(getattr(fracture_client, owner), method)), place)
                if owner != "Admin":
                    twin = getattr(getattr(fracture_client, "Async" + owner), method)
                    self.assertTrue(inspect.iscoroutinefunction(twin) or method in ("progress", "jobs"), f"Async{place}")

    def test_asyncio_has_the_same_parameters(self):
        for owner in ("Client", "Mesh", "Job", "Answer"):
            ours, twins = getattr(fracture_client, owner), getattr(fracture_client, "Async" + owner)
            for name, method in inspect.getmembers(ours, inspect.isfunction):
                if name.startswith("_") or name in ("close", "of_mesh", "save"):
                    continue
                wanted = [p for p in inspect.signature(method).parameters if p != "cancel"]  # a task has its own cancellation
                self.assertEqual(list(inspect.signature(getattr(twins, name)).parameters), wanted, f"Async{owner}.{name}")

    def test_no_option_has_the_name_of_a_parameter(self):
        parameters = set(interface()["components"]["schemas"]["Parameters"]["properties"])
        self.assertGreater(len(parameters), 50)
        for place in ("Mesh.fracture", "Mesh.figures", "Mesh.job", "Client.job", "Client.fracture", "Client.put", "Client.inspect"):
            owner, method = place.split(".")
            names = set(inspect.signature(getattr(getattr(fracture_client, owner), method)).parameters)
            self.assertLessEqual(names & parameters, {"format"}, place)  # here it is a parameter of the request itself

    def test_who_is_busy_is_waited_for_and_nobody_else(self):
        """Compared with the statuses in the server's own tables."""
        codes = (ROOT / "common/base/error_codes.def").read_text(encoding="utf-8")
        slugs = dict(re.findall(r'^FRACTURE_ERROR\((\w+), "([\w-]+)"', codes, re.MULTILINE))
        table = (ROOT / "server/http/problems.def").read_text(encoding="utf-8")
        statuses = {slugs[name]: int(status) for name, status in re.findall(r"^FRACTURE_STATUS\((\w+), (\d+)", table, re.MULTILINE)}
        statuses.update((slug, int(status)) for slug, status in
                        re.findall(r'^FRACTURE_HTTP_PROBLEM\(\w+, "([\w-]+)", "[^"]*", (\d+)', table, re.MULTILINE))
        self.assertEqual(statuses.keys(), problems.SERVER.keys())
        for slug, status in statuses.items():
            self.assertEqual(problems.SERVER[slug] is Reaction.WAIT, status in (429, 503), slug)

    def test_media_types_are_those_of_the_interface(self):
        document = interface()
        for path, method in (("/meshes/{id}", "put"), ("/fracture", "post")):
            content = document["paths"][path][method]["requestBody"]["content"]
            self.assertEqual(media_types(content), set(upload.MEDIA_TYPES.values()), path)
            self.assertIn("multipart/form-data", content)

    def test_figures_that_the_interface_fixes(self):
        """Numbers that descriptions state in words."""
        document = interface()
        fracture = document["paths"]["/fracture"]["post"]["requestBody"]["content"]["multipart/form-data"]["schema"]["properties"]
        self.assertIn(f"up to {upload.MOST_FILES} additional files", fracture["file"]["description"])
        body = document["paths"]["/meshes/{id}/fracture"]["post"]["requestBody"]["content"]["application/json"]["schema"]
        self.assertIn(f"At most {fracture_client.mesh.MOST_PARAMETER_BYTES // 1024} KiB", body["description"])


class Language(unittest.TestCase):
    def test_every_file_is_python_3_9(self):
        files = sorted((PACKAGE / "fracture_client").glob("*.py"))
        self.assertGreater(len(files), 10)
        for file in files:
            ast.parse(file.read_text(encoding="utf-8"), file.name, feature_version=(3, 9))

    def test_everything_public_says_what_it_is(self):
        for name in fracture_client.__all__:
            thing = getattr(fracture_client, name)
            if not inspect.isclass(thing):
                continue
            self.assertTrue(thing.__doc__, name)
            for method, function in inspect.getmembers(thing, inspect.isfunction):
                if not method.startswith("_") and not name.startswith("Async") and function.__module__.startswith("fracture_client"):
                    self.assertTrue(function.__doc__, f"{name}.{method}")
                    hints = inspect.signature(function)
                    self.assertIsNot(hints.return_annotation, inspect.Signature.empty, f"{name}.{method}")


if __name__ == "__main__":
    main()
