// The checks by which tests of hits judge an answer.
#pragma once

#include <cstdint>

#include "common/hits/delta.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture::test {

/// Expects answers that are equal to the bit, including companions and report.
void expect_same(const FracturedSolid& a, const FracturedSolid& b);

/// Expects that the delta is the difference of the two answers. Each answer is fracture()d from scratch.
void expect_difference(const FracturedSolid& before, const FracturedSolid& after, const Delta& delta);

/// Applies hit after hit, each to the result of the one before. Every result must equal the whole fracture
/// with all sites, with bonds across parts. Short tests make every answer and compare only the last one.
/// Returns the number of local answers.
int expect_hits(const Mesh& mesh, const FractureParameters& all, int threads = 1);

/// Hits at several places of the mesh's box. The last two are at the same place.
FractureParameters hits_on(const Mesh& mesh, std::uint32_t sites, double radius,
                           std::uint64_t seed = 20261121);

}  // namespace fracture::test
