// Describes what make_solid() found and did: remarks for people, and its refusals.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "common/base/error.hpp"
#include "common/solid/edges.hpp"
#include "common/solid/solid.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// Formats to six digits: "2.5", "(1, 2.5, 0)".
std::string number(double value);
std::string place(const Vec3f& p);

/// Number of faulty edges of each kind, and the first ones.
struct EdgeFaults {
  std::uint64_t open = 0;         ///< edges with one use
  std::uint64_t nonmanifold = 0;  ///< edges with more than two
  std::uint64_t one_way = 0;      ///< edges with two uses in the same direction
  std::optional<std::array<Vec3f, 2>> first_open, first_nonmanifold;
};
EdgeFaults find_faults(const Surface& surface, const EdgeTable& edges, const Execution& execution);

/// Returns kMeshNotClosed, with the counts and the first faulty edge.
tl::unexpected<Error> refuse(std::string detail, const EdgeFaults& faults, const SolidReport& report);

/// The pieces without volume, which are not part of the solid.
struct FlatPieces {
  std::uint64_t triangles = 0;  ///< of the source
  Vec3f first{};                ///< a corner of the first one
  std::string node;             ///< its node; empty if it has no name
};

/// `options`: those used, with the thickness of slabs in metres.
void write_remarks(const EdgeFaults& faults, const SolidReport& report, std::size_t layers,
                   const FlatPieces& flat, const SolidOptions& options, Remarks& remarks);

}  // namespace fracture::solid_detail
