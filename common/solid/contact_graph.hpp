// The parts of a solid that overlap, touch or come within a gap. The module `contacts` computes this, and the
// solid stores it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/base/vec.hpp"

namespace fracture {

enum class ContactKind : std::uint8_t {
  kOverlapping,  ///< the parts have some volume in common
  kTouching,     ///< no common volume, but the surfaces come within the gap of each other
};

/// How the area of a contact was measured.
enum class ContactMeasure : std::uint8_t {
  kFacing,  ///< surface from which a ray along the outward normal meets the other part within the gap
  kInside,  ///< surface inside the other part
  kCommon,  ///< surface that both parts share, with the same outside, as between a part and its copy
};

/// Two parts in contact.
struct Contact {
  std::uint32_t a = 0, b = 0;  ///< indices into Solid::parts, a < b
  ContactKind kind = ContactKind::kTouching;
  /// m². Touching: the smaller of the two facing areas; 0 if only edges or corners meet. Overlapping: the smaller of
  /// the two areas inside the other part, or the smaller facing area if that is larger, so a contact does not
  /// become weaker when a gap closes. Surface that coincides exactly with the other surface is not inside. If one part is
  /// entirely inside the other: its area inside. For a part and its copy: the area that they share.
  double area = 0;
  /// m. The centroid of the areas of both parts. If the area is 0: the middle of the intersection of both boxes, widened by
  /// the gap.
  Vec3d place;
  /// Unit length, from a to b: the mean, over the areas, of the outward normals of a and the inward normals of b. If
  /// they cancel, as for a part inside the other: from the middle of the box of a to that of b, or +x.
  Vec3d normal;
  double volume = 0;  ///< m³ that both parts fill; 0 if they are touching
  ContactMeasure measure = ContactMeasure::kFacing;
  bool of_b = false;  ///< the area is that of the surface of b; otherwise of a
  friend bool operator==(const Contact&, const Contact&) = default;
};

/// A convex piece of a contact's measured surface, within one triangle of the measured part.
struct ContactPiece {
  std::array<Vec3d, 4> corners;  ///< m, in either orientation; a triangle repeats its last corner
  Vec3f normal;                  ///< unit, outwards from the measured part; 0 for a common surface
  float height;  ///< m: distance of the other part's surface along the normal; 0 unless the measure is facing
  double area;   ///< m²: its share of the contact's area, about the area of the polygon
};

struct ContactGraph {
  double gap = 0;                 ///< m
  std::vector<Contact> contacts;  ///< by a, then by b; at most one for each pair of parts
  std::vector<ContactPiece> pieces{};
  /// Each contact's first piece, and the end. The pieces of a contact add up to its area, apart from rounding.
  std::vector<std::uint32_t> first_piece{};
};

}  // namespace fracture
