// A solid as the directed edges of its flat faces, and its division by planes. A face may have holes and several
// outlines: it is an unordered set of edges around its normal, and as many edges begin as end at each corner. Therefore a
// cut needs no triangulation: it closes each face along the plane, and the closing edges bound the cut's own face.
// This is Sutherland & Hodgman (1974) for faces with any outline; crossings are paired along the line as in a scanline.
//
// The side of a corner is decided once, so both sides are closed regardless of rounding. Corners are doubles. Rounding
// only moves the cut, by far less than the inset of a hull (collision_hulls.hpp).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/disjoint_sets.hpp"
#include "common/base/pacer.hpp"
#include "common/base/scratch.hpp"
#include "common/base/vec.hpp"

namespace fracture {

/// dot(normal, x) = offset; the normal is a unit vector.
struct CutPlane {
  Vec3d normal;
  double offset = 0;
};

struct Polyhedron {
  struct Edge {
    std::uint32_t from, to;  ///< counter-clockwise from outside; holes are clockwise
  };
  struct Face {
    std::uint32_t end;  ///< end of its range of edges, which begins at the previous face's end
    Vec3d normal;       ///< unit, outwards; {} for a face without an area
  };
  std::vector<Vec3d> points;
  std::vector<Edge> edges;
  std::vector<Face> faces;

  void clear() {
    points.clear();
    edges.clear();
    faces.clear();
  }
  std::size_t bytes() const { return bytes_of_vectors(points, edges, faces); }
  void release() { release_vectors(points, edges, faces); }
};

/// Volume by the divergence theorem, in the points' unit cubed. Negative if the solid is inside out.
double volume_of(const Polyhedron& solid, Pacer& pacer);

/// Divides solids by planes. Reuses its memory for the next cut.
class PolyhedronCutter {
 public:
  /// A connected piece of the solid on one side of the plane.
  struct Body {
    std::uint32_t side;  ///< 0: below the plane, 1: above
    std::uint32_t root;  ///< its point with the lowest index on that side
    double volume;
    std::uint32_t first, count;  ///< range in corners_
  };

  /// Divides `whole` into bodies(). Those below the plane come first, ordered by the lowest index of their points. Corners at
  /// most `rounding` off the plane count as on it. A face in the plane belongs to the side that contains the solid.
  void cut(const Polyhedron& whole, const CutPlane& plane, double rounding, Pacer& pacer);

  std::span<const Body> bodies() const { return bodies_; }
  /// Points of the body, including all its extreme points.
  std::span<const Vec3d> corners(const Body& body) const {
    return std::span<const Vec3d>(corners_).subspan(body.first, body.count);
  }
  /// The area of the cut, on one side.
  double cut_area() const { return cut_area_; }
  void write(const Body& body, Polyhedron& out, Pacer& pacer);

  std::size_t bytes() const;
  void release();

 private:
  using Edge = Polyhedron::Edge;
  /// The point at which the plane crosses an edge; the two sides have a corner each.
  struct Crossing {
    std::uint32_t hi,
        next;  ///< the edge's upper end; the next crossing of an edge with the same lower end
    std::array<std::uint32_t, 2> corner;  ///< per side
  };
  struct Side {
    Polyhedron solid;
    std::vector<Edge> cap;               ///< edges of the cut
    DisjointSets together, outlines;     ///< sets of points: bodies; connected outlines of the cut
    std::vector<std::uint32_t> body_of;  ///< per point: its root, and its body once these are listed
    void clear();
  };
  /// A point at which a face leaves or enters the space above the plane.
  struct Passage {
    double along;
    std::uint32_t crossing;
  };

  void divide_points(const Polyhedron& whole, double rounding, Pacer& pacer);
  std::uint32_t crossing(const Polyhedron& whole, std::uint32_t a, std::uint32_t b, double rounding);
  bool lies_on_plane(const Polyhedron& whole, std::size_t first, std::size_t end, double rounding) const;
  void cancel_cap();
  void divide_face(const Polyhedron& whole, std::size_t face, double rounding);
  void close_face(const Vec3d& face_normal);
  void end_face(const Vec3d& normal);
  void join_across_holes(std::uint32_t side, Pacer& pacer);
  void list_bodies(std::uint32_t side, Pacer& pacer);

  CutPlane plane_;
  Vec3d origin_;  // on the plane, so that the cut's face adds nothing to volumes
  Vec3d u_, v_;   // along the plane, orthogonal
  std::array<Side, 2> sides_;
  std::vector<double> height_;          // per point
  std::vector<std::uint32_t> number_;   // per point, on its side
  std::vector<std::uint32_t> crossed_;  // per point: the first crossing of an edge with this lower end
  std::vector<Crossing> crossings_;
  std::vector<Passage> leaves_, enters_;  // of one face
  std::vector<char> is_off_;              // per point of a side: whether it is off the plane
  std::vector<double> amount_;            // per point of a side, at roots: volume, area
  std::vector<std::uint32_t> at_root_;  // per point of a side, at roots: an outline's leftmost point, a body
  std::vector<Body> bodies_;
  std::vector<Vec3d> corners_;
  double cut_area_ = 0;
  bool has_faces_on_plane_ = false;
};

}  // namespace fracture
