// What tests of hits hold an answer to.
#pragma once

#include <cstdint>

#include "common/hits/delta.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture::test {

/// To the bit, companions and report, too.
void expect_same(const FracturedSolid& a, const FracturedSolid& b);

/// The delta is the difference of the two answers, each fracture()d from nothing.
void expect_difference(const FracturedSolid& before, const FracturedSolid& after, const Delta& delta);

/// Hit after hit, each on what the one before left: all of it as the whole fracture with all sites makes it, with bonds
/// across parts. In short tests every answer is made, and the last one is compared. Returns how many of the answers were local.
int expect_hits(const Mesh& mesh, const FractureParameters& all, int threads = 1);

/// Hits at several places of the mesh's box, the last two at the same.
FractureParameters hits_on(const Mesh& mesh, std::uint32_t sites, double radius,
                           std::uint64_t seed = 20261121);

}  // namespace fracture::test
