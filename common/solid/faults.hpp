// What was found and done, in words: notes for people, and the refusals of make_solid().
#pragma once

#include <array>
#include <optional>
#include <string>

#include "common/base/error.hpp"
#include "common/solid/edges.hpp"
#include "common/solid/solid.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// "2.5", "(1, 2.5, 0)": to six digits.
std::string number(double value);
std::string place(const Vec3f& p);

/// What is wrong with the edges, and where first.
struct EdgeFaults {
  std::uint64_t open = 0;         ///< edges with one use
  std::uint64_t nonmanifold = 0;  ///< edges with more than two
  std::uint64_t one_way = 0;      ///< edges with two uses in the same direction
  std::optional<std::array<Vec3f, 2>> first_open, first_nonmanifold;
};
EdgeFaults find_faults(const Surface& surface, const EdgeTable& edges, const Execution& execution);

/// kMeshNotClosed, with the counts and the first offending edge.
tl::unexpected<Error> refuse(std::string detail, const EdgeFaults& faults, const SolidReport& report);

/// The pieces without a volume, which are not in the solid.
struct FlatPieces {
  std::uint64_t triangles = 0;  ///< of the source
  Vec3f first{};                ///< a corner of the first one
  std::string node;             ///< that it is in; empty: without a name
};

/// `thickness`: SolidOptions::thickness.
void write_remarks(const EdgeFaults& faults, const SolidReport& report, std::size_t layers,
                   const FlatPieces& flat, double thickness, Remarks& remarks);

}  // namespace fracture::solid_detail
