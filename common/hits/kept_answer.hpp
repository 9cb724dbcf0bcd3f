// What is kept of an answer for the hits on it. Copies share what they have in common, so that an answer after a
// hit costs what the hit has changed.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/cell_map.hpp"
#include "common/base/shared_blocks.hpp"
#include "common/clip/restricted_diagram.hpp"
#include "common/delaunay/kept_tetrahedralization.hpp"
#include "common/fragment/make_fragments.hpp"
#include "common/fragment/unions.hpp"
#include "common/hits/fragment_figures.hpp"
#include "common/hits/local_rough.hpp"
#include "common/pipeline/fracture.hpp"
#include "common/pipeline/fracture_steps.hpp"

namespace fracture {

/// A bond of shared caps, kept at the cell of its lower fragment. For cells that stay together, this is the lowest of them.
struct KeptBond {
  std::uint32_t fragment;        ///< of that cell: its number there
  SiteId other_cell;             ///< not lower; of cells that stay together the lowest
  std::uint32_t other_fragment;  ///< its number there
  double area;
  Vec3d centroid, normal;  ///< as Bond has them
};

/// What winds around a Voronoi vertex, as InnerVertex says it.
struct PartWinding {
  std::uint32_t part;
  std::int32_t winding;
  auto operator<=>(const PartWinding&) const = default;
};

/// The different things that wind around Voronoi vertices, numbered: most have nothing around them, or one part.
class WindingStates {
 public:
  static constexpr std::uint32_t kNothing = 0;
  std::uint32_t number_of(const std::vector<PartWinding>& state) {
    const auto [at, is_new] = numbers_.emplace(state, static_cast<std::uint32_t>(all_.size()));
    if (is_new) all_.push_back(state);
    return at->second;
  }
  /// kNoIndex: not there.
  std::uint32_t find(const std::vector<PartWinding>& state) const {
    const auto at = numbers_.find(state);
    return at == numbers_.end() ? kNoIndex : at->second;
  }
  const std::vector<PartWinding>& operator[](std::uint32_t number) const { return all_[number]; }
  std::size_t size() const { return all_.size(); }

 private:
  std::vector<std::vector<PartWinding>> all_{{}};
  std::map<std::vector<PartWinding>, std::uint32_t> numbers_{{{}, kNothing}};
};

/// Unions of pieces, and which cells have pieces in them.
struct KeptUnions {
  std::vector<Union> all;  ///< ascending
  std::vector<std::pair<SiteId, std::uint32_t>>
      of_cell;  ///< the lowest cells that have pieces in them; ascending

  KeptUnions() = default;
  KeptUnions(std::vector<Union> unions, const Execution& execution);
  /// Calls visit(number) for each that a piece of the cell, or of those that it is the lowest of, belongs to.
  template <class Visit>
  void each_of(SiteId lowest, const Visit& visit) const {
    for (auto at = std::lower_bound(of_cell.begin(), of_cell.end(), std::pair{lowest, 0u});
         at != of_cell.end() && at->first == lowest; ++at)
      visit(at->second);
  }
};

/// What hits need that change only what is near to them.
struct LocalBase {
  KeptTetrahedralization tetrahedra;
  SharedBlocks<std::uint32_t, 256> state;  ///< per tetrahedron: what winds around its Voronoi vertex
  std::shared_ptr<const WindingStates> states;
  SharedBlocks<SiteId, 256> label;                      ///< per vertex of the solid: its cell
  SharedBlocks<std::shared_ptr<const KeptCell>> cells;  ///< per site
  /// Per site the lowest of the cells that stay together with its own; empty: every cell is for itself.
  SharedBlocks<SiteId, 256> lowest;
  SharedBlocks<std::shared_ptr<const std::vector<KeptBond>>> bonds;  ///< per site; null: none
  FragmentFigures figures;
  CellMap map{};
  SiteNotes notes;
  std::shared_ptr<const Solid> image{};  ///< of the solid under the map, where there is one
  SizeFigures size{};
  std::uint32_t pattern_sites = 0;  ///< those of the pattern: the first ones
  /// What the limits of size had united before hits came. Which of these are fragments depends on where hits are
  /// (unions_beside_hits() in pipeline/before_hits.hpp).
  std::shared_ptr<const KeptUnions> unions{};
  std::shared_ptr<const KeptUnions> late{};  ///< CutCells::late, all of them fragments or parts of one
  std::optional<LocalRough> rough{};         ///< where cuts are
  std::shared_ptr<const std::vector<std::uint32_t>>
      bricks{};                ///< RestrictedDiagram::bricks; null: there are none
  std::size_t cell_bytes = 0;  ///< of memory behind `cells`; those that answers share are counted by each

  SiteId lowest_of(SiteId s) const { return lowest.size() == 0 ? s : lowest[s]; }
};

/// An answer as far as further hits need it: reusable for any number of them.
struct FracturedBase {
  /// Hits can be local: every fragment is a piece of one cell, or of cells that stay together, or united because of its
  /// size: with flat cuts, of some of the pattern, or beside hits; nothing else was united, nor dropped, kept or split. Where
  /// not, the whole is fractured again.
  std::optional<LocalBase> local{};
  /// Where it is not: the fragments, in the order of the answer.
  std::vector<KeptFragment> fragments{};
};

/// The size in bytes, including the object itself.
std::size_t memory_size(const KeptCell& cell);
std::size_t memory_size(const FracturedBase& base);

/// Per cell the triangles of the solid that meet it, ascending. Throws Interrupted.
std::vector<std::vector<std::uint32_t>> triangles_by_cell(const Solid& solid, const SurfaceCuts& cuts,
                                                          std::size_t cells, const Execution& execution);

/// Takes notes while an answer is made whole.
class LocalBaseMaker {
 public:
  /// Called when the clipper has finished.
  void see(const RestrictedDiagram& restricted, const Execution& execution);
  /// How the fragments came about: takes it out of the cut.
  void see(CutCells& cut);
  /// When the answer is there. Nothing where the tetrahedralization cannot be kept. Throws Interrupted.
  std::optional<LocalBase> make(const FracturedSolid& answer, const Diagram& diagram,
                                const Execution& execution);

 private:
  Box box_;  // of the solid as it was seen
  std::vector<std::uint32_t> state_;
  WindingStates states_;
  std::vector<SiteId> label_;
  std::vector<std::vector<std::uint32_t>> triangles_;  // per site
  std::shared_ptr<const Solid> image_;
  std::vector<SiteId> lowest_;
  std::vector<std::uint32_t> pieces_;  // per site
  std::vector<Union> unions_, late_;
  std::shared_ptr<const std::vector<std::uint32_t>> bricks_;
};

/// Fragment k with its hulls.
KeptFragment kept_fragment(const FracturedSolid& answer, std::uint32_t k, const Execution& execution);

/// All fragments, bonds and hulls of an answer that is local, with the certificate, as fracture() makes them
/// before they are judged. Throws Interrupted.
CutCells all_cells_of(const Solid& solid, const LocalBase& base, const Execution& execution);

/// The certificate of the whole answer, apart from crossing caps.
Certificate certificate_of(const Solid& solid, const FragmentFigures& figures);

}  // namespace fracture
