// Crossings of the triangles of two parts, and the share of a triangle that is inside the other part.
#pragma once

#include <array>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/contacts/moved_signs.hpp"
#include "common/contacts/near_triangles.hpp"
#include "common/contacts/vertex_windings.hpp"

namespace fracture::contacts_detail {

/// Sums over the crossings of a triangle, in coordinates relative to its corner 0, so that the two edges at
/// this corner contribute nothing to integrals.
struct Crossed {
  Vec3d across;  ///< Σ tail x head over the segments, m²
  Vec3d moment;  ///< Σ (normal · tail x head)(tail + head), m³
  double jumps_at = 0,
         jumps_at_squares = 0;  ///< Σ jump · x and Σ jump · x² over crossings of edge 1, x along it
  EdgeJumps jumps{};
  bool crossed = false;
};

/// The two ends of a segment, m.
struct Ends {
  Vec3d tail, head;
  bool has_tail = false, has_head = false;
};

/// A segment along which a triangle crosses the other part, m. The side inside the other part is on its
/// left.
struct Segment {
  std::uint32_t triangle;  ///< in NearPair::a or b
  Vec3d tail, head;
};
/// Change of the winding number at a place on an edge.
struct EdgeJump {
  std::uint32_t triangle;
  std::uint32_t edge;
  std::int32_t jump;
  double x;  ///< along the edge, 0 to 1
};

/// Finds all crossings of a pair. Borrows the solid and the pair.
class Crossings {
 public:
  /// `a`, `b`: the exact corners of the pair's triangles, not relative to its middle. Throws Interrupted.
  Crossings(const Solid& solid, const NearPair& pair, std::vector<Corners> a, std::vector<Corners> b,
            Pacer& pacer);
  bool any() const { return any_; }
  const std::vector<Crossed>& of(Owner owner) const { return owner == Owner::kA ? of_a_ : of_b_; }
  const std::vector<Corners>& corners(Owner owner) const { return owner == Owner::kA ? a_ : b_; }
  const MovedSigns& signs() const { return signs_; }
  /// The segments of all triangles, in no particular order.
  const std::vector<Segment>& segments(Owner owner) const { return owner == Owner::kA ? lines_a_ : lines_b_; }
  const std::vector<EdgeJump>& jumps(Owner owner) const { return owner == Owner::kA ? jumps_a_ : jumps_b_; }

 private:
  std::pair<Vec3d, double> place_on(const NearTriangle& s, std::size_t k, const NearTriangle& t) const;
  void add_crossing(Owner owner, std::uint32_t i, std::size_t k, const NearTriangle& t, int jump, Ends& of_s,
                    Ends& of_t);
  void add_segment(Owner owner, std::uint32_t i, const Ends& ends);
  void cross_pair(std::uint32_t i, std::uint32_t k, const Corners& a, const Corners& b);

  const Solid& solid_;
  const NearPair& pair_;
  std::vector<Corners> a_, b_;
  MovedSigns signs_;
  std::vector<Crossed> of_a_, of_b_;
  std::vector<Segment> lines_a_, lines_b_;
  std::vector<EdgeJump> jumps_a_, jumps_b_;
  bool any_ = false;
};

/// Returns the corners of each triangle as they are in the solid.
std::vector<Corners> exact_corners(const PartSurfaces& surfaces, const std::vector<NearTriangle>& triangles);

/// Returns the area and moment of the triangle's region inside the other part.
Patch inside_of(const NearTriangle& t, const Crossed& crossed, const std::array<int, 3>& windings);

}  // namespace fracture::contacts_detail
