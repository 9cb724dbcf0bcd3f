"""configuration.py SUBJECT FRACTURE_SERVER: tests whether programs accept the files in docker/ and whether the files
fit together.

SUBJECT is haproxy, compose, monitoring, kubernetes or systemd. The checks that do not require the subject's program
come first; then the program itself is asked. Exits with 0 if all is well, with 1 and a list of the faults, or with 77
(skipped) if only the program is missing.
"""
import glob
import json
import os
import re
import sys
import tempfile
import time

import yaml

from farm_files import DOCKER, SERVER, ask_program, documents, expect, fracture_a_cube, get, read, run, serving
from memory_plan import expect_memory_plan, in_bytes

def settings():
    """Returns the names of the server's settings as environment variables."""
    names = re.findall(r"^(?:# )?([a-z][a-z-]*) = ", run(SERVER, "serve", "--print-config"), re.M)
    return {"FRACTURE_" + name.upper().replace("-", "_") for name in names}


def expect_settings(variables, where):
    unknown = {v for v in variables if v.startswith("FRACTURE_")} - settings()
    expect(not unknown, f"{where}: {unknown} are no settings of fracture-server")


def expect_time_to_stop(seconds, variables, where):
    """Checks the time to stop: drain delay, grace, two seconds for cancelled work and one second for the log."""
    needed = float(variables["FRACTURE_DRAIN_DELAY"]) + float(variables["FRACTURE_GRACE"]) + 3
    expect(seconds >= needed, f"{where}: {seconds} s to stop are less than the {needed} s that the server may take")


def expect_secrets(variables, files, where):
    """Checks that a server with Redis logs in as its own user and signs the entries it leaves there. `files` are the
    files handed to the server."""
    if "FRACTURE_REDIS" not in variables:
        return
    expect(variables.get("FRACTURE_REDIS_USER") == "fracture", f"{where}: Redis knows it by no name")
    for setting in "FRACTURE_REDIS_PASSWORD_FILE", "FRACTURE_FARM_KEY_FILE":
        expect(variables.get(setting) in files, f"{where}: {setting} names no secret")
    expect(not any(f.endswith("redis-users") for f in files), f"{where} is handed the users of Redis")


def expect_users_of_redis(command, files, where):
    users = command[command.index("--aclfile") + 1] if "--aclfile" in command else None
    expect(files == {users}, f"{where}: Redis takes everybody's word, or holds more secrets than it needs")


def haproxy():
    text = read("haproxy", "haproxy.cfg")
    deadline = float(re.search(r"^(?:# )?deadline = ([\d.]+)", run(SERVER, "serve", "--print-config"), re.M)[1])
    for side in "client", "server":
        seconds = int(re.search(rf"timeout {side} (\d+)s", text)[1])
        expect(seconds > deadline, f"timeout {side}: the proxy gives up before the server's deadline of {deadline} s")
    expect("option abortonclose" in text, "a client that leaves does not stop its computation")
    program = ask_program("haproxy")
    path = os.path.join(DOCKER, "haproxy", "haproxy.cfg")
    run(program, "-c", "-f", path)
    if os.path.exists("/etc/resolv.conf"):  # nginx reads the file in this case
        run(program, "-c", "-f", path, FRACTURE_PODS="localhost")


def compose():
    document = yaml.safe_load(read("compose.yaml"))
    services = document["services"]
    servers = [name for name in services if re.fullmatch(r"fracture\d", name)]
    expect(len(servers) == 3, "three servers")
    for name in servers:
        service = services[name]
        expect_settings(service["environment"], name)
        expect_time_to_stop(int(service["stop_grace_period"].rstrip("s")), service["environment"], name)
        expect(service["read_only"] and service["cap_drop"] == ["ALL"], f"{name} has more rights than it needs")
        expect(f"{name}:8080" in read("haproxy", "haproxy.cfg"), f"HAProxy does not know {name}")
        expect(f"{name}:8081" in read("monitoring", "prometheus.yaml"), f"Prometheus does not know {name}")
        expect("no-new-privileges:true" in service["security_opt"], f"{name} may gain privileges")
        expect("seccomp:./seccomp.json" in service["security_opt"], f"{name} may call whatever it likes")
        expect_secrets(service["environment"], {f"/run/secrets/{s}" for s in service["secrets"]}, name)
        expect("FRACTURE_TRUSTED_PROXY" in service["environment"], f"{name} takes all clients for one")
    expect_memory_plan(in_bytes(services[servers[0]]["mem_limit"]), None, services[servers[0]]["cpus"],
                       services[servers[0]]["environment"], "compose.yaml")
    expect_users_of_redis(services["redis"]["command"], {f"/run/secrets/{s}" for s in services["redis"]["secrets"]}, "compose.yaml")
    for name, source in document["secrets"].items():
        expect(source == {"file": f"./secrets/{name}"}, f"the secret {name} is not one of docker/make-secrets")
    for name, service in services.items():
        expect(set(service.get("secrets", [])) <= set(document["secrets"]), f"{name} has a secret that is not there")
        expect("restart" in service and "mem_limit" in service, f"{name}: no restart policy or no limit of memory")
        for volume in service.get("volumes", []):
            if volume.startswith("./"):
                expect(os.path.isfile(os.path.join(DOCKER, volume.split(":")[0])), f"{name} mounts {volume}")
        for port in service.get("ports", []):
            expect(port.startswith("127.0.0.1:"), f"{name}: {port} can be reached from other machines")
    image = dict(re.findall(r"(FRACTURE_\w+)=(\S+)", read("Dockerfile").split("\nENV ")[1]))
    expect_settings(image, "Dockerfile")
    program = ask_program("docker-compose")
    os.chdir(DOCKER)  # version 1 searches for the seccomp profile from here
    run(program, "-f", "compose.yaml", "--profile", "monitoring", "config", "-q")


def served_metrics():
    """Returns the names of the samples that a server with every tier has after a request."""
    with serving("--redis", "127.0.0.1:1") as (port, admin):
        fracture_a_cube(port, 2)
        text = ""
        while "fracture_request_duration_seconds_bucket" not in text:  # counted only after the answer
            time.sleep(0.01)  # pause: serving() ends the server after a while, and that ends the loop
            text = get(admin, "/metrics")
    return set(re.findall(r"^([a-z_]+)", text, re.M))


def monitoring():
    dashboard = json.loads(read("monitoring", "grafana", "fracture.json"))
    expressions = [target["expr"] for panel in dashboard["panels"] for target in panel.get("targets", [])]
    rules = [rule for group in documents("monitoring", "alerts.yaml")[0]["groups"] for rule in group["rules"]]
    expressions += [rule["expr"] for rule in rules]
    expressions += [rule["seriesQuery"] for rule in documents("monitoring", "prometheus-adapter.yaml")[0]["rules"]["custom"]]
    known = served_metrics() | {"up"}
    for expression in expressions:
        used = set(re.findall(r"\b(?:fracture|process)_\w+|\bup\b", re.sub(r'"[^"]*"', '""', expression)))
        expect(used and used <= known, f"{used - known} of '{expression}' are no metrics of the server")
    guide = read("README.md")
    for rule in rules:
        expect(rule["alert"] in guide, f"docker/README.md does not say what to do about {rule['alert']}")
    program = ask_program("promtool")
    run(program, "check", "config", os.path.join(DOCKER, "monitoring", "prometheus.yaml"))
    run(program, "test", "rules", os.path.join(DOCKER, "monitoring", "alerts_test.yaml"))


def check_pods(kind, name, pod):
    for scope in pod, *pod["containers"]:
        context = scope["securityContext"]
        if scope is pod:
            expect(context["runAsNonRoot"] and context["runAsUser"] > 0, f"{kind} {name} may run as root")
            expect(context["seccompProfile"]["type"] in ("RuntimeDefault", "Localhost"), f"{kind} {name} may call whatever it likes")
        else:
            expect(context["readOnlyRootFilesystem"] and not context["allowPrivilegeEscalation"]
                   and context["capabilities"]["drop"] == ["ALL"], f"{kind} {name} has more rights than it needs")
            expect("memory" in scope["resources"]["limits"], f"{kind} {name} has no limit of memory")


def check_network(policies, deployments, labels, where):
    """Checks that every pod is closed in both directions, and that only the port that asks for tokens is open to
    everybody."""
    ports = {p["name"] for d in deployments.values() for c in d["spec"]["template"]["spec"]["containers"] for p in c["ports"]}
    for name, own in labels.items():
        closed = set()
        for policy in policies.values():
            if policy["spec"]["podSelector"]["matchLabels"].items() <= own.items():
                closed |= set(policy["spec"]["policyTypes"])
        expect(closed == {"Ingress", "Egress"}, f"{where}: {name} is open in the network")
    for name, policy in policies.items():
        spec = policy["spec"]
        rules = [(r, r.get("from")) for r in spec.get("ingress", [])] + [(r, r.get("to")) for r in spec.get("egress", [])]
        for rule, peers in rules:
            named = [p["port"] for p in rule["ports"]]
            expect(all(p in ports or p == 53 for p in named), f"{where}: {name} opens {named}, which nobody listens on")
            expect(peers or named == ["http"], f"{where}: {name} opens {named} to everybody")
            for peer in peers or []:
                pods = peer.get("podSelector", {}).get("matchLabels", {})
                known = [n for n, own in labels.items() if pods.items() <= own.items()]
                # The large overlay adds the proxies that the policy of the base names.
                expect(known or pods.get("app.kubernetes.io/name") == "fracture-proxy", f"{where}: {name} is for {pods}, which is nobody")


def handed_to(pod, container):
    """Returns the paths of the secrets in a container, without those of the tokens."""
    mounts = {m["name"]: m["mountPath"] for m in container["volumeMounts"]}
    return {f"{mounts[v['name']]}/{item['path']}" for v in pod["volumes"] if "secret" in v and v["name"] in mounts
            for item in v["secret"].get("items", [])}


def check_disruptions(by_kind, where):
    """Checks that a node can be drained, and that a pod is left if there is more than one."""
    scalers = {m["spec"]["scaleTargetRef"]["name"]: m["spec"]["minReplicas"]
               for m in by_kind.get("HorizontalPodAutoscaler", {}).values()}
    for name, deployment in by_kind.get("Deployment", {}).items():
        least = scalers.get(name, deployment["spec"].get("replicas", 1))
        labels = deployment["spec"]["template"]["metadata"]["labels"]
        budgets = [m["spec"] for m in by_kind.get("PodDisruptionBudget", {}).values()
                   if m["spec"]["selector"]["matchLabels"].items() <= labels.items()]
        expect(len(budgets) == 1 or (least == 1 and not budgets), f"{where}: {name} has {len(budgets)} disruption budgets")
        for budget in budgets:
            expect(1 <= budget["maxUnavailable"] <= max(1, least - 1), f"{where}: {name} is blocked, or all of it may go at once")


def check_manifests(manifests, where):
    """Checks one whole overlay: every reference finds its object."""
    by_kind = {}
    for m in manifests:
        by_kind.setdefault(m["kind"], {})[m["metadata"]["name"]] = m
    deployments = by_kind.get("Deployment", {})
    for kind in "Deployment", "Job":
        for name, workload in by_kind.get(kind, {}).items():
            pod = workload["spec"]["template"]["spec"]
            check_pods(kind, name, pod)
            for volume in pod.get("volumes", []):
                for source, key, of in ("configMap", "name", "ConfigMap"), ("secret", "secretName", "Secret"):
                    if source in volume:
                        expect(volume[source][key] in by_kind.get(of, {}), f"{where}: {name} mounts a {of} that is not there")
    labels = {name: d["spec"]["template"]["metadata"]["labels"] for name, d in deployments.items()}
    for name, deployment in deployments.items():
        expect(deployment["spec"]["selector"]["matchLabels"].items() <= labels[name].items(), f"{where}: {name} does not select its pods")
    for kind in "Service", "PodDisruptionBudget":
        for name, m in by_kind.get(kind, {}).items():
            selector = m["spec"]["selector"]
            selector = selector.get("matchLabels", selector)
            selected = [d for d, l in labels.items() if selector.items() <= l.items()]
            expect(len(selected) == 1, f"{where}: {kind} {name} selects {selected}")
            if kind == "Service":
                ports = [p["name"] for c in deployments[selected[0]]["spec"]["template"]["spec"]["containers"] for p in c["ports"]]
                expect(all(p["targetPort"] in ports for p in m["spec"]["ports"]), f"{where}: {name} leads to no port")
    check_disruptions(by_kind, where)
    check_network(by_kind.get("NetworkPolicy", {}), deployments, labels, where)
    for name, scaler in by_kind.get("HorizontalPodAutoscaler", {}).items():
        expect(scaler["spec"]["scaleTargetRef"]["name"] in deployments, f"{where}: {name} scales nothing")

    if "fracture" not in deployments:
        return
    pod = deployments["fracture"]["spec"]["template"]["spec"]
    container = pod["containers"][0]
    configuration = by_kind["ConfigMap"][container["envFrom"][0]["configMapRef"]["name"]]["data"]
    expect_settings(configuration, where)
    expect_time_to_stop(pod["terminationGracePeriodSeconds"], configuration, where)
    for probe, path in ("startupProbe", "/livez"), ("readinessProbe", "/readyz"), ("livenessProbe", "/livez"):
        expect(container[probe]["httpGet"] == {"path": path, "port": "admin"}, f"{where}: {probe}")
    resources = container["resources"]
    cores = resources["requests"]["cpu"]
    cores = max(1, int(cores[:-1]) // 1000) if cores.endswith("m") else int(cores)
    expect_memory_plan(in_bytes(resources["limits"]["memory"]), in_bytes(resources["requests"]["memory"]), cores, configuration, where)
    expect_secrets(configuration, handed_to(pod, container), where)
    if "fracture-redis" in deployments:
        redis = deployments["fracture-redis"]["spec"]["template"]["spec"]
        expect_users_of_redis(redis["containers"][0]["args"], handed_to(redis, redis["containers"][0]), where)
    expect({"/cache", "/tmp"} <= {m["mountPath"] for m in container["volumeMounts"]}, f"{where}: nowhere to write")
    cache = next(v for v in pod["volumes"] if v["name"] == "cache")["emptyDir"]["sizeLimit"]
    stored = sum(int(configuration[v]) for v in ("FRACTURE_DISK_CACHE", "FRACTURE_JOB_STORE"))
    expect(int(cache.removesuffix("Gi")) << 30 > stored, f"{where}: /cache is smaller than the {stored} bytes that go there")


def check_bake_job():
    """Checks that a pod of the bake Job succeeds if a mesh of its shard is refused, because Kubernetes would retry the pod in vain."""
    container = documents("kubernetes", "bake", "job.yaml")[0]["spec"]["template"]["spec"]["containers"][0]
    with tempfile.TemporaryDirectory() as folder:
        for name, text in ("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), ("bake.ndjson", '{"input": "flat.obj", "output": "flat.glb"}\n'):
            with open(os.path.join(folder, name), "w", encoding="utf-8") as f:
                f.write(text)
        run(SERVER, *(arg.replace("/assets", folder) for arg in container["args"]), JOB_COMPLETION_INDEX="0")
        with open(os.path.join(folder, "bake.ndjson.0-of-16.report"), encoding="utf-8") as f:
            expect(json.load(f)["status"] == "refused", "bake: the report does not list the refused mesh")


def kubernetes():
    for path in glob.glob(os.path.join(DOCKER, "kubernetes", "**", "*.yaml"), recursive=True) + [
            os.path.join(DOCKER, "haproxy", name) for name in ("kustomization.yaml", "kubernetes.yaml")]:
        for m in documents(path):
            expect("apiVersion" in m and "kind" in m, f"{path}: a manifest without apiVersion or kind")
            if m["kind"] != "Kustomization":
                continue
            expect(path.endswith("/kustomization.yaml"), f"{path} is not called kustomization.yaml")
            generated = [f for g in m.get("configMapGenerator", []) + m.get("secretGenerator", []) for f in g.get("files", [])]
            for entry in m.get("bases", []) + m.get("resources", []) + m.get("patchesStrategicMerge", []) + generated:
                expect(os.path.exists(os.path.join(os.path.dirname(path), entry)), f"{path}: there is no {entry}")
    check_manifests(documents("kubernetes", "bake", "job.yaml"), "bake")
    check_bake_job()
    program = ask_program("kubectl")
    scaled_by = {"overlays/small": ["Resource"], "overlays/large": ["Resource", "Pods"], "bake": None}
    for overlay, metrics in scaled_by.items():
        rendered = run(program, "kustomize", os.path.join(DOCKER, "kubernetes", overlay))
        manifests = [m for m in yaml.safe_load_all(rendered) if m]
        check_manifests(manifests, overlay)
        for m in manifests:
            if m["kind"] == "HorizontalPodAutoscaler":
                expect([metric["type"] for metric in m["spec"]["metrics"]] == metrics, f"{overlay}: scaled by {m['spec']['metrics']}")


def systemd():
    unit = read("systemd", "fracture-server.service")
    variables = dict(v.split("=", 1) for line in re.findall(r"^Environment=(.*)$", unit, re.M) for v in line.split())
    expect_settings(variables, "fracture-server.service")
    expect_time_to_stop(float(re.search(r"^TimeoutStopSec=(\d+)$", unit, re.M)[1]), variables, "fracture-server.service")
    program = ask_program("systemd-analyze")
    with tempfile.TemporaryDirectory() as folder:  # the program need not be installed for this
        path = os.path.join(folder, "fracture-server.service")
        with open(path, "w", encoding="utf-8") as f:
            f.write(unit.replace("/usr/bin/fracture-server", SERVER))
        run(program, "verify", path)


globals()[sys.argv[1]]()
print(f"{sys.argv[1]}: all is well")
