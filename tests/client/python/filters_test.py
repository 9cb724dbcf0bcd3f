"""Collision filters exclude exactly the pairs that they are made from, as those of the server do."""
import itertools
import random
import unittest

from support import main
from fracture_client.filters import collision_filters


def excluded(filters, a, b):
    """As KHR_physics_rigid_bodies has it: one of the two lists the system of the other."""
    x, y = filters[a], filters[b]
    return x is not None and y is not None and (y[0] in x[1] or x[0] in y[1])


class Filters(unittest.TestCase):
    def test_they_are_not_transitive(self):
        filters = collision_filters(4, [(0, 1), (1, 2)])
        self.assertEqual(filters, [(1, ()), (0, (1,)), (1, ()), None])  # 0 and 2 are twins

    def test_twins_share_a_system(self):
        filters = collision_filters(5, [(0, 2), (0, 3), (0, 4), (1, 2), (1, 3), (1, 4)])
        self.assertEqual(filters, [(1, ()), (1, ()), (0, (1,)), (0, (1,)), (0, (1,))])

    def test_any_pairs_are_excluded_and_no_others(self):
        numbers = random.Random(20261129)
        for bodies in range(2, 30):
            pairs = [pair for pair in itertools.combinations(range(bodies), 2) if numbers.random() < 0.2]
            filters = collision_filters(bodies, pairs)
            for a, b in itertools.combinations(range(bodies), 2):
                self.assertEqual(excluded(filters, a, b), (a, b) in pairs)


if __name__ == "__main__":
    main()
