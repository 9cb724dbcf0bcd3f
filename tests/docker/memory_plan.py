"""Tests whether the memory limits and requests in docker/ fit the server's memory plan."""
import re

from farm_files import expect, samples, serving


def in_bytes(quantity):
    """Converts a quantity as Kubernetes or compose writes it to bytes."""
    number, unit = re.fullmatch(r"([\d.]+)([A-Za-z]*)", str(quantity)).groups()
    return float(number) * 1024 ** {"": 0, "k": 1, "m": 2, "g": 3, "t": 4}[unit.lower().removesuffix("i").removesuffix("b")]


def expect_memory_plan(limit, request, cores, variables, where):
    """Checks the limits with the server's own plan. Everything must fit into the limit, even on a machine with many
    cores. The memory that is kept when nothing is in progress must fit into the request, which the scheduler sets
    aside."""
    sizes = {name: value for name, value in variables.items()
             if not name.endswith(("_FILE", "_USER", "_ALLOW_HOST")) and name != "FRACTURE_REDIS"}
    for threads in cores, 64:
        with serving("--memory", str(int(limit)), "--threads", str(threads), "--import-workers", str(threads), "--redis", "127.0.0.1:1",
                     **sizes) as (_, admin):
            now = samples(admin)
        budgets = {part: now[f'fracture_memory_budget_bytes{{part="{part}"}}'] for part in re.findall(
            r'fracture_memory_budget_bytes{part="(\w+)"}', "\n".join(now))}
        base = now["fracture_memory_base_bytes"]
        expect(base + 1.3 * sum(budgets.values()) <= limit, f"{where}: the plan is over the limit of {limit} bytes on {threads} cores")
        expect(budgets["working"] >= 256 << 20, f"{where}: little is left to work in on {threads} cores")
        for setting, part in ("FRACTURE_MAX_WORKING", "working"), ("FRACTURE_RESULT_CACHE", "result_cache"):
            expect(setting not in sizes or budgets[part] == float(sizes[setting]), f"{where}: {setting}")
        if threads == cores and request:
            kept = ("mesh_cache", "diagram_cache", "result_cache", "mesh_store", "job_results", "answer_ledger")
            at_rest = base + 1.3 * sum(budgets[part] for part in kept)
            expect(at_rest <= request <= limit, f"{where}: a full server at rest has {at_rest / 2**20:.0f} MiB, its request is "
                   f"{request / 2**20:.0f} MiB")
