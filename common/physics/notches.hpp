// Notches, the edges at which a solid bends inwards, and planes that could divide it there. An edge between two faces is
// a notch if the solid takes more than half a turn around it. Planes through it that are inside the solid resolve it: those of
// its two faces, and the one between them (Chazelle 1984, "Convex partitions of polyhedra", cuts each notch this way).
// Approximate decompositions begin with the notches that are deepest below the hull (Lien & Amato 2007).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/base/scratch.hpp"
#include "common/physics/collision_hulls.hpp"
#include "common/physics/polyhedron.hpp"

namespace fracture {

class NotchPlanes {
 public:
  struct Candidate {
    CutPlane plane;
    double votes;  ///< share of the total weight of notches that lies in notches near the plane
  };

  /// Returns at most `most` planes, by descending votes. Each notch votes for its three planes, with the product of its depth
  /// below `hull`, its length and its bend. Votes for nearly equal planes are added. `size`: longest side of the whole solid.
  /// Valid until the next call. Throws Interrupted.
  std::span<const Candidate> find(const Polyhedron& solid, const CollisionHull& hull, double size,
                                  std::size_t most, const Execution& execution);

  std::size_t bytes() const {
    return bytes_of_vectors(open_, next_, face_of_, notches_, walls_, candidates_);
  }
  void release() { release_vectors(open_, next_, face_of_, notches_, walls_, candidates_); }

 private:
  struct Notch {
    Vec3d middle, along;  ///< unit
    Vec3d left, right;    ///< normals of its faces
    double weight;
    std::uint32_t edge;
  };

  void list_notches(const Polyhedron& solid, Pacer& pacer);
  void weigh(const CollisionHull& hull, Pacer& pacer);
  void vote(const CutPlane& plane, const Notch& notch, double size);

  std::vector<std::uint32_t> open_, next_;  // edges without a twin yet: first one per point; next one
  std::vector<std::uint32_t> face_of_;      // per edge
  std::vector<Notch> notches_;
  std::vector<CutPlane> walls_;  // of the hull
  std::vector<Candidate> candidates_;
};

}  // namespace fracture
