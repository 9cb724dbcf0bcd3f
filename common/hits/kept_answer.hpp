// The stored data of an answer for hits on it. Copies share unchanged data, so the cost of an answer after a
// hit depends on what the hit has changed.
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

/// A bond of shared caps, stored at the cell of its lower fragment. For cells that stay together, this is the
/// lowest of them.
struct KeptBond {
  std::uint32_t fragment;        ///< index in that cell
  SiteId other_cell;             ///< not lower; if cells stay together, the lowest of them
  std::uint32_t other_fragment;  ///< index in the other cell
  double area;
  Vec3d centroid, normal;  ///< as in Bond
};

/// A part that winds around a Voronoi vertex, as in InnerVertex.
struct PartWinding {
  std::uint32_t part;
  std::int32_t winding;
  auto operator<=>(const PartWinding&) const = default;
};

/// The distinct sets of parts that wind around Voronoi vertices, numbered. Most vertices have no part around
/// them, or one.
class WindingStates {
 public:
  static constexpr std::uint32_t kNothing = 0;
  std::uint32_t number_of(const std::vector<PartWinding>& state) {
    const auto [at, is_new] = numbers_.emplace(state, static_cast<std::uint32_t>(all_.size()));
    if (is_new) all_.push_back(state);
    return at->second;
  }
  /// kNoIndex if not found.
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

/// Unions of pieces, and an index of the cells with pieces in them.
struct KeptUnions {
  std::vector<Union> all;  ///< ascending
  std::vector<std::pair<SiteId, std::uint32_t>>
      of_cell;  ///< (lowest cell, union) for each cell with a piece in the union; ascending

  KeptUnions() = default;
  KeptUnions(std::vector<Union> unions, const Execution& execution);
  /// Calls visit(number) for each union that contains a piece of this cell, or of the cells that it is the
  /// lowest of.
  template <class Visit>
  void each_of(SiteId lowest, const Visit& visit) const {
    for (auto at = std::lower_bound(of_cell.begin(), of_cell.end(), std::pair{lowest, 0u});
         at != of_cell.end() && at->first == lowest; ++at)
      visit(at->second);
  }
};

/// The sheets that fragments carry, by the ids of the fragments. Kept fragments themselves have none.
using KeptSheets = std::map<std::uint64_t, std::shared_ptr<const Fragment>>;

/// The data with which a hit changes only its surroundings.
struct LocalBase {
  KeptTetrahedralization tetrahedra;
  SharedBlocks<std::uint32_t, 256> state;  ///< per tetrahedron: the state around its Voronoi vertex
  std::shared_ptr<const WindingStates> states;
  SharedBlocks<SiteId, 256> label;                      ///< per vertex of the solid: its cell
  SharedBlocks<std::shared_ptr<const KeptCell>> cells;  ///< per site
  /// Per site: the lowest of the cells that stay together with its cell; empty: every cell is alone.
  SharedBlocks<SiteId, 256> lowest;
  SharedBlocks<std::shared_ptr<const std::vector<KeptBond>>> bonds;  ///< per site; null: none
  FragmentFigures figures;
  CellMap map{};
  SiteNotes notes;
  std::shared_ptr<const Solid> image{};  ///< image of the solid under the map, if there is one
  SizeFigures size{};
  std::uint32_t pattern_sites = 0;  ///< number of sites of the pattern, which come first
  /// Unions made by the size limits before any hit. The positions of hits decide which of these are fragments
  /// (unions_beside_hits() in pipeline/before_hits.hpp).
  std::shared_ptr<const KeptUnions> unions{};
  std::shared_ptr<const KeptUnions> late{};  ///< CutCells::late; all of them are fragments or parts of one
  std::optional<LocalRough> rough{};         ///< set if cuts are rough
  std::shared_ptr<const std::vector<std::uint32_t>>
      bricks{};  ///< RestrictedDiagram::bricks; null if there are none
  std::shared_ptr<const KeptSheets> sheets = std::make_shared<const KeptSheets>();
  std::size_t cell_bytes = 0;  ///< memory behind `cells`; answers that share memory each count it

  SiteId lowest_of(SiteId s) const { return lowest.size() == 0 ? s : lowest[s]; }
};

/// The data of an answer that further hits need; reusable for any number of hits.
struct FracturedBase {
  /// Set if hits can be local. Then every fragment is a piece of one cell or of cells that stay together, or
  /// was united because of its size: with flat cuts, among the pattern's pieces, or near hits. No other
  /// pieces were united, dropped, kept or split. If hits cannot be local, the whole is fractured again.
  std::optional<LocalBase> local{};
  /// If `local` is not set: the fragments, in the order of the answer.
  std::vector<KeptFragment> fragments{};
};

/// The size in bytes, including the object itself.
std::size_t memory_size(const KeptCell& cell);
std::size_t memory_size(const FracturedBase& base);

/// Returns, per cell, the triangles of the solid that meet it, ascending. Throws Interrupted.
std::vector<std::vector<std::uint32_t>> triangles_by_cell(const Solid& solid, const SurfaceCuts& cuts,
                                                          std::size_t cells, const Execution& execution);

/// Collects the data while a whole answer is made.
class LocalBaseMaker {
 public:
  /// To be called when the clipper has finished.
  void see(const RestrictedDiagram& restricted, const Execution& execution);
  /// Records how the fragments were made, and moves the data out of the cut. `adds_contacts`: whether the answer's bonds will
  /// include contacts between parts; these are not stored, but computed again after each hit.
  void see(CutCells& cut, bool adds_contacts);
  /// To be called when the answer is complete. Returns nothing if the tetrahedralization cannot be stored.
  /// Throws Interrupted.
  std::optional<LocalBase> make(const FracturedSolid& answer, const Diagram& diagram,
                                const Execution& execution);

 private:
  Box box_;  // of the solid or its image
  std::vector<std::uint32_t> state_;
  WindingStates states_;
  std::vector<SiteId> label_;
  std::vector<std::vector<std::uint32_t>> triangles_;  // per site
  std::shared_ptr<const Solid> image_;
  std::vector<SiteId> lowest_;
  std::vector<std::uint32_t> pieces_;  // per site
  std::vector<Union> unions_, late_;
  std::optional<std::vector<Bond>> cap_bonds_;  // if the answer's bonds also include contacts
  std::shared_ptr<const std::vector<std::uint32_t>> bricks_;
};

/// Returns fragment k with its hulls.
KeptFragment kept_fragment(const FracturedSolid& answer, std::uint32_t k, const Execution& execution);

/// Returns all fragments, bonds and hulls of a local answer, with the certificate, like fracture() before
/// they are checked. Throws Interrupted.
CutCells all_cells_of(const Solid& solid, const LocalBase& base, const Execution& execution);

/// Returns the certificate of the whole answer, except for crossing caps.
Certificate certificate_of(const Solid& solid, const FragmentFigures& figures);

}  // namespace fracture
