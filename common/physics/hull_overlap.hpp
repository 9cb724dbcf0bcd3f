// How deep two convex hulls overlap: the least distance by which one of them must move so that they only touch. This is the
// distance of the origin from the surface of their Minkowski difference. The expanding polytope algorithm finds it (van den
// Bergen 2001, "Proximity queries and penetration depth computation on 3D game objects"). Like the algorithm of Gilbert,
// Johnson & Keerthi (1988), it only needs the difference's farthest point in a given direction.
//
// Two departures:
//   - The polytope need not contain the origin at first. The next face to move outwards is the one that the origin is highest
//     above, or least below. So a single loop finds out whether the hulls are apart, and measures those that are not.
//   - The polytope's corners are on a grid of 2^19 steps, where orientations are exact in 64-bit integers: there are no
//     tolerances, and coplanar faces need no care. The grid only decides the direction; the depth in this direction is
//     measured in double on the points as they are. It is never too small, and too large by about three steps at most.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/base/scratch.hpp"
#include "common/base/vec.hpp"

namespace fracture {

struct HullDepth {
  double depth = 0;  ///< m; <= 0: the hulls are apart, by at least -depth
  Vec3d normal;      ///< unit length; if b moves by the depth along it, the hulls touch
};

/// Reuses its memory for the next pair. Each thread needs its own.
class HullOverlap {
 public:
  /// Measures two hulls, given by their points (m) in one frame, at least one point each. Throws Interrupted.
  HullDepth measure(std::span<const Vec3d> a, std::span<const Vec3d> b, Pacer& pacer);

  std::size_t bytes() const { return bytes_of_vectors(a_, b_, faces_, rim_); }
  void release() { release_vectors(a_, b_, faces_, rim_); }

 private:
  struct Point {  // on the grid; components of a difference are less than 2^19
    std::int64_t x, y, z;
    bool operator==(const Point&) const = default;
  };
  struct Face {
    std::array<Point, 3> corners;  ///< counter-clockwise from outside
    Point normal;                  ///< less than 2^41
    double depth;                  ///< of the origin below the face, in steps
  };
  struct Edge {
    Point from, to;
  };

  static Point minus(const Point& p, const Point& q) { return {p.x - q.x, p.y - q.y, p.z - q.z}; }
  static Point opposite(const Point& p) { return {-p.x, -p.y, -p.z}; }
  static Point cross(const Point& p, const Point& q) {
    return {p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
  }
  static std::int64_t dot(const Point& p, const Point& q) { return p.x * q.x + p.y * q.y + p.z * q.z; }

  void round(std::span<const Vec3d> a, std::span<const Vec3d> b);
  bool reaches_beyond(const Point& direction, Point& farthest);
  template <class IsWanted>
  bool find_corner(std::span<const Point> directions, const IsWanted& is_wanted, Point& corner);
  bool begin_with_a_tetrahedron();
  void add_face(const Point& a, const Point& b, const Point& c);
  void add_corner(const Point& corner);

  std::vector<Point> a_, b_;
  std::vector<Face> faces_;  // of a convex polytope between corners of the difference a - b
  std::vector<Edge> rim_;
  Point direction_{};  // last one used
};

}  // namespace fracture
