// The vertices of refined caps while they move. They are moved by noise, and moved less where triangles cross
// or turn over.
//
// Movement is reduced in rounds, and each round depends only on the positions of the vertices in it. If these
// are known for the rest of a diagram (trace.hpp), a part can be computed alone. The cuts of the rest that the
// part can meet are given, and repeat the calmings of their trace. If the part would change how the rest is
// calmed, calm() returns the cells concerned.
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
#include "common/rough/trace.hpp"

namespace fracture {

class MovingCaps {
 public:
  /// Maximum number of calmings to store.
  static constexpr std::size_t kMostCalmings = 1 << 18;

  /// `seen`: per triangle; triangles inside a fragment are not part of a cut and cannot be met. `sites`:
  /// number of each site in the whole; empty if this is the whole. All member functions throw Interrupted.
  MovingCaps(RestrictedDiagram& restricted, std::vector<char> seen, std::span<const SiteId> sites,
             const Execution& execution);

  /// Reduces the movement of restrained caps. Must be called before move().
  void restrain(const Restraints& restraints);
  void move(const Displacement& displacement, const SurfaceTree& outside);

  /// Returns the cuts that are seen, in the form that is stored. Must be called after move().
  std::vector<KeptCut> cuts() const;
  /// Adds cuts of the rest. `before`: the calmings in the previous whole, ascending. `made`: the sites,
  /// numbered as in the whole and ascending, whose caps are made here. Must be called once, after move().
  void give(std::span<const KeptCut* const> cuts, std::span<const Calming> before,
            std::span<const SiteId> made);

  struct Outcome {
    /// Number of triangle pairs that cross at the end. None if too many would have to be tested; then every
    /// vertex is back at its original position.
    std::optional<std::uint64_t> crossing;
    std::uint64_t looked_at = 0;    ///< number of triangle pairs tested
    bool complete = false;          ///< whether calmings were requested and there are few enough to store
    std::vector<Calming> calmings;  ///< calmings due to caps made here; ascending, without duplicates
    std::vector<SiteId> spread;     ///< cells of the whole whose caps would change
  };
  /// Reduces movements until nothing crosses. Removes the given cuts afterwards.
  Outcome calm(const SurfaceTree& outside, bool trace);
  /// Number of places with reduced movement.
  std::uint64_t calmed() const;

 private:
  struct Facet {
    SiteId lo, hi;  // numbers in the whole
    std::size_t frame;
    Vec3d normal;
  };
  bool is_fixed(std::size_t v) const {
    return v < fixed_ || (v >= made_vertices_ && given_fixed_[v - made_vertices_]);
  }
  std::size_t number(CutVertexId id) const { return id - positions_.first_constructed; }
  std::size_t region_of(std::uint32_t triangle) const;
  std::array<SiteId, 4> cells_of(std::uint32_t s, std::uint32_t t) const;
  void place(std::size_t v);
  void find_coinciding();
  bool is_made(SiteId s) const;
  template <class Visit>
  void each_outer(const Visit& visit);
  void find_expected();
  void sort_calmings(std::vector<Calming>& calmings) const;
  std::vector<SiteId> changed_otherwise();
  void add_turned_over(double tolerance, const std::vector<char>& suspects, std::vector<char>& bad,
                       std::vector<CrossingPair>* named);
  bool calm_round(std::uint32_t round, const std::vector<char>& bad, const std::vector<CrossingPair>& named,
                  std::vector<char>& calmed, Outcome& out);
  void take_away_given();

  const Execution& execution_;
  Pacer pacer_;
  const VoronoiDiagram& diagram_;
  Caps& caps_;
  VertexPositions& positions_;
  std::vector<char> seen_;
  std::vector<Facet> facets_;                 // per region
  std::vector<std::uint32_t> region_begin_;   // first triangle of each region, then the total
  const std::size_t fixed_;                   // number of vertices on the surface, which come first
  std::size_t made_vertices_, made_regions_;  // those with higher numbers are given
  std::vector<char> given_fixed_;
  // Per constructed vertex.
  std::vector<Vec3d> flat_;
  std::vector<Vec3d> moves_;
  std::vector<double> surface_;  // distance to the surface, up to the reach of the displacement
  std::vector<double> share_;    // share of the movement that remains
  std::vector<char> moved_;
  std::vector<std::uint32_t> leader_;  // the lowest vertex at the same place that is equally fixed or movable
  std::vector<std::uint32_t> order_;   // vertices sorted by place
  // Data of the rest of the whole.
  std::span<const Calming> before_;
  std::span<const SiteId> made_;
  /// Per leader, one bit per round: calmed in the previous whole; calmed because of the rest only.
  std::vector<std::uint64_t> expected_, replayed_;
  std::vector<char> outer_;  // per leader: belongs to a cell that is not made here; or kOtherwise
  std::uint64_t rounds_expected_ = 0;
};

}  // namespace fracture
