// A kept region in the image of a solid: a convex polyhedron in each frame of the map of cells.
#pragma once

#include <vector>

#include "common/base/vec.hpp"
#include "common/pipeline/keep_region.hpp"
#include "common/solid/image.hpp"

namespace fracture {

/// The points with normal · x <= offset; the normal is a unit vector.
struct KeptFacet {
  Vec3d normal;
  double offset = 0;
  double depth(const Vec3d& p) const { return offset - dot(normal, p); }
};

/// The number of facets that replace a sphere: the directions of a geodesic polyhedron, 10 · 3² + 2. The
/// facets touch the sphere, so the polyhedron holds it, and has 3.5 % more volume.
inline constexpr std::size_t kSphereFacets = 92;
/// The corners of this polyhedron are nearer to the centre than this many radii.
inline constexpr double kSphereReach = 1.04;

class KeptSpace {
 public:
  struct Frame {
    std::vector<KeptFacet> facets;
    Box box;  ///< of the solid's parts in this frame
    /// Whether the facet divides the box. Other facets do not matter.
    std::vector<bool> divides;
    bool meets = true;  ///< false if the region is certainly outside the box
  };
  /// Facets are on the site lattice if they are parallel to its axes, and otherwise a few steps of it farther
  /// out, so that rounded sites make no cut inside the region. `seen` is seen through `seen.map()`.
  KeptSpace(const Region& region, const SeenSolid& seen);

  const std::vector<Frame>& frames() const { return frames_; }
  const Frame& at(const Vec3d& image) const { return frames_[map_.index_at(image)]; }
  /// How far a point of the image is inside the region, m; negative: how far beyond its farthest facet. Minus
  /// infinity if the region does not meet the frame's box.
  double depth(const Vec3d& image) const;
  /// Whether a site is inside, so that its cell belongs to the kept fragment.
  bool holds(const Vec3d& site) const { return depth(site) > 0; }

 private:
  CellMap map_;
  std::vector<Frame> frames_;
};

}  // namespace fracture
