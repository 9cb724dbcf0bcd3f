"""Collision filters of KHR_physics_rigid_bodies, made from the pairs of fragments that must not collide, as the server makes them
(common/physics/collision_filters.hpp)."""
from __future__ import annotations

from typing import Dict, List, Optional, Sequence, Tuple

MOST_SYSTEMS = 32

Filter = Tuple[int, Tuple[int, ...]]  # a system, and the systems with which it must not collide


def collision_filters(bodies: int, pairs: Sequence[Tuple[int, int]]) -> List[Optional[Filter]]:
    """Returns each body's filter; None for a body that is in no pair. `pairs` has indices a < b, in ascending order. Bodies in
    system 0 are not excluded by any filter."""
    partners: List[List[int]] = [[] for _ in range(bodies)]
    for a, b in pairs:
        partners[b].append(a)
    for a, b in pairs:
        partners[a].append(b)
    classes: Dict[Tuple[int, ...], int] = {}  # bodies with the same partners
    class_of = [classes.setdefault(tuple(own), len(classes)) if own else -1 for own in partners]
    edges = [(class_of[a], class_of[b]) for a, b in pairs]
    named: List[int] = []
    while len(named) + 1 < MOST_SYSTEMS:
        count = [0] * len(classes)
        for x, y in edges:
            if x not in named and y not in named:
                count[x] += 1
                count[y] += 1
        if not any(count):
            break
        named.append(count.index(max(count)))
    system = {own: 1 + k for k, own in enumerate(sorted(named))}
    return [(system.get(own, 0), tuple(sorted({system[class_of[other]] for other in partners[k] if class_of[other] in system})))
            if own >= 0 else None for k, own in enumerate(class_of)]
