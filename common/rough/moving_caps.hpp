// The vertices of refined caps on their way: moved by noise, and moved less where triangles cross or turn over.
//
// What makes them move less goes in rounds, and each round is a function of where vertices are in it. Who knows that of
// the rest of a diagram (trace.hpp) can do it for a part alone: the rest is given, as far as it lies in the part's
// way, and follows its trace. Where the part would make it do otherwise, that is told: calm() names the cells.
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
  /// Calmings that are worth keeping.
  static constexpr std::size_t kMostCalmings = 1 << 18;

  /// `seen`: per triangle; those inside a fragment are no cuts and in nobody's way. `sites`: per site its number in
  /// the whole; empty: it is the whole. Throws Interrupted, as everything here.
  MovingCaps(RestrictedDiagram& restricted, std::vector<char> seen, std::span<const SiteId> sites,
             const Execution& execution);

  /// Before move(): vertices of restrained caps get their share of the movement.
  void restrain(const Restraints& restraints);
  void move(const Displacement& displacement, const SurfaceTree& outside);

  /// The caps that are seen as what is kept of them. After move().
  std::vector<KeptCut> cuts() const;
  /// Cuts of the rest. `before`: what was calmed in the whole as it was, ascending; `made`: per site of the whole, ascending,
  /// whose caps are made here. Once, after move().
  void give(std::span<const KeptCut* const> cuts, std::span<const Calming> before,
            std::span<const SiteId> made);

  struct Outcome {
    /// Of triangles that cross at the end; nothing where too many would have to be looked at: then everything is
    /// back in its place.
    std::optional<std::uint64_t> crossing;
    std::uint64_t looked_at = 0;  ///< pairs of triangles
    bool complete = false;        ///< the calmings are: they were asked for, and are not too many to be kept
    std::vector<Calming>
        calmings;  ///< what was calmed because of caps that are made here; ascending, none twice
    std::vector<SiteId> spread;  ///< cells of the whole whose caps would no longer do what they did
  };
  /// The given cuts are gone afterwards.
  Outcome calm(const SurfaceTree& outside, bool trace);
  /// Places where something is moved less than it might be.
  std::uint64_t calmed() const;

 private:
  struct Facet {
    SiteId lo, hi;  // in the whole
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
  std::vector<std::uint32_t> region_begin_;   // the first triangle of each region, and how many there are
  const std::size_t fixed_;                   // the vertices before are on the surface
  std::size_t made_vertices_, made_regions_;  // those after are given
  std::vector<char> given_fixed_;
  // Per constructed vertex.
  std::vector<Vec3d> flat_;
  std::vector<Vec3d> moves_;
  std::vector<double> surface_;  // distance, up to the reach of fading
  std::vector<double> share_;    // of the movement
  std::vector<char> moved_;
  std::vector<std::uint32_t>
      leader_;                        // the lowest vertex at the same place that is fixed, or is not, like it
  std::vector<std::uint32_t> order_;  // vertices by place
  // Of the rest.
  std::span<const Calming> before_;
  std::span<const SiteId> made_;
  /// Per leader, a bit a round: calmed in the whole as it was; because of the rest alone.
  std::vector<std::uint64_t> expected_, replayed_;
  std::vector<char> outer_;  // per leader: has vertices of cells that are not made; kOtherwise
  std::uint64_t rounds_expected_ = 0;
};

}  // namespace fracture
