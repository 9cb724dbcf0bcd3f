// The vertices of refined caps while they move. They are moved by noise, and moved less where triangles cross
// or turn over. Movement is reduced in rounds.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/bvh/surface_tree.hpp"
#include "common/clip/restricted_diagram.hpp"
#include "common/rough/crossings.hpp"
#include "common/rough/displacement.hpp"
#include "common/rough/restraint.hpp"

namespace fracture {

class MovingCaps {
 public:
  /// `seen`: per triangle; triangles inside a fragment are not part of a cut and cannot be met. All member
  /// functions throw Interrupted.
  MovingCaps(RestrictedDiagram& restricted, std::vector<char> seen, const Execution& execution);

  /// Reduces the movement of restrained caps. Must be called before move().
  void restrain(const Restraints& restraints);
  void move(const Displacement& displacement, const SurfaceTree& outside);

  /// Reduces movements until nothing crosses. Returns the number of triangle pairs that cross at the end. Returns nothing
  /// if too many would have to be tested; then every vertex is back at its original position.
  std::optional<std::uint64_t> calm(const SurfaceTree& outside);
  /// Number of places with reduced movement.
  std::uint64_t calmed() const;

 private:
  struct Facet {
    std::size_t frame;
    Vec3d normal;
  };
  bool is_fixed(std::size_t v) const { return v < fixed_; }
  std::size_t number(CutVertexId id) const { return id - positions_.first_constructed; }
  void place(std::size_t v);
  void find_coinciding();
  void add_turned_over(double tolerance, const std::vector<char>& suspects, std::vector<char>& bad);
  bool calm_round(std::uint32_t round, const std::vector<char>& bad, std::vector<char>& calmed);

  const Execution& execution_;
  Pacer pacer_;
  const VoronoiDiagram& diagram_;
  Caps& caps_;
  VertexPositions& positions_;
  std::vector<char> seen_;
  std::vector<Facet> facets_;                // per region
  std::vector<std::uint32_t> region_begin_;  // first triangle of each region, then the total
  const std::size_t fixed_;                  // number of vertices on the surface, which come first
  // Per constructed vertex.
  std::vector<Vec3d> flat_;
  std::vector<Vec3d> moves_;
  std::vector<double> surface_;  // distance to the surface, up to the reach of the displacement
  std::vector<double> share_;    // share of the movement that remains
  std::vector<char> moved_;
  std::vector<std::uint32_t> leader_;  // the lowest vertex at the same place that is equally fixed or movable
  std::vector<std::uint32_t> order_;   // vertices sorted by place
};

}  // namespace fracture
