// A stored tetrahedralization to which further sites can be added. Copies share the unchanged data, so the
// cost of an insertion depends on what it changes, not on the size of the whole. The tetrahedra in conflict
// with the new sites (Watson 1981) are removed, IncrementalDelaunay fills their space, and the new ones are
// joined to the rest.
//
// Vertices 0..3 are the corners of the big tetrahedron, and vertex 4 + s is site s. The numbers of tetrahedra
// have no meaning, and are reused.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/id_table.hpp"
#include "common/base/pacer.hpp"
#include "common/base/shared_blocks.hpp"
#include "common/delaunay/big_tetrahedron.hpp"
#include "common/delaunay/incremental.hpp"
#include "common/delaunay/tetrahedralization.hpp"
#include "common/exact/binary_scale.hpp"
#include "common/exact/orient3d.hpp"

namespace fracture {

class KeptTetrahedralization {
 public:
  struct Tet {
    std::array<TetVertexId, 4> v;  ///< positive; v[0] is kNoVertex for an unused number
    std::array<TetId, 4> n;
  };
  static constexpr TetVertexId kNoVertex{0xffffffffu};

  /// Numbers tetrahedra as in `whole`. `box` is the box that `whole` was made for. Returns nothing if the box
  /// is empty. Linear. Throws Interrupted.
  static std::optional<KeptTetrahedralization> of(const Tetrahedralization& whole, const Box& box,
                                                  const Execution& execution);

  std::uint32_t site_count() const { return static_cast<std::uint32_t>(points_.size()) - 4; }
  Vec3d site(SiteId s) const { return points_[4 + s]; }
  std::uint32_t tet_count() const { return static_cast<std::uint32_t>(tets_.size() - free_.size()); }
  /// 1 + the largest number of a tetrahedron.
  TetId tet_end() const { return TetId{tets_.size()}; }
  const Tet& tet(TetId t) const { return tets_[t]; }
  /// Number of points given so far, including duplicates but not dropped points; and the number of
  /// duplicates.
  std::uint64_t given() const { return given_; }
  std::uint32_t duplicates_merged() const { return duplicates_merged_; }

  /// The changes made by an insertion. All tetrahedra at a new site are new, and no others.
  struct Insertion {
    std::vector<TetId> gone, made;      ///< numbers in both lists were reused
    std::vector<std::uint32_t> points;  ///< index of the point of each new site; ascending
  };
  /// Inserts the points. Those that are not duplicates become the next sites, in order. Returns nothing if
  /// the result would differ from tetrahedralize() on all sites. This happens if a point is outside the box
  /// (which would move the big tetrahedron), if a point is nearer to the whole box than some site outside
  /// (which would be dropped), or if the limits are exceeded. Then the object must not be used any more. This
  /// also applies if Interrupted is thrown.
  std::optional<Insertion> insert(std::span<const Vec3d> further, const Execution& execution);

  /// All tetrahedra at some sites, as a separate tetrahedralization.
  struct Part {
    Tetrahedralization tetrahedra;  ///< canonical; neighbours outside the part are kNoTet
    std::vector<SiteId> sites;      ///< per site of the part: number in the whole, ascending
    std::vector<char> whole;        ///< per site of the part: added, so it has all its tetrahedra
    std::vector<TetId> tets;        ///< per tetrahedron of the part: number in the whole
    /// The number of a site in the part. The part must contain the site.
    SiteId local(SiteId s) const;
  };
  class PartMaker;

 private:
  explicit KeptTetrahedralization(const Box& box) : box_(box) {}
  struct Conflicts;
  TetId locate(const Vec3d& p, TetId start) const;
  TetId start_near(const Vec3d& p) const;
  int orient3d(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) const {
    return exact::orient3d(a, b, c, d, scale_);
  }
  const Vec3d& at(TetVertexId v) const { return points_[v]; }

  BigTetrahedron big_;
  Box box_;
  double farthest_outside2_ = 0;  ///< largest squared distance from the box of a site outside the box
  exact::BinaryScale scale_;
  SharedBlocks<Vec3d> points_;  // per vertex
  SharedBlocks<TetId, 256> tet_of_vertex_;
  SharedBlocks<Tet> tets_;
  std::vector<TetId> free_;
  std::uint64_t given_ = 0;
  std::uint32_t duplicates_merged_ = 0;
};

/// Collects a part, star by star. Near-linear in the result.
class KeptTetrahedralization::PartMaker {
 public:
  /// Borrows both arguments.
  PartMaker(const KeptTetrahedralization& kept, const Execution& execution)
      : kept_(kept), execution_(execution), pacer_(execution) {}

  /// Adds all tetrahedra at the site, and calls visit(site) for each site of the part that is reached for the
  /// first time. Throws Interrupted.
  template <class Visit>
  void add(SiteId s, const Visit& visit);
  void add(SiteId s) {
    add(s, [](SiteId) {});
  }
  Part finish();

 private:
  /// Returns the tetrahedron's number in the part. `is_new` becomes true if it had none before.
  std::uint32_t number_of(TetId t, bool& is_new) {
    std::uint32_t& slot = number_.slot(t);
    is_new = slot == IdTable::kEmpty;
    if (is_new) {
      slot = static_cast<std::uint32_t>(tets_.size());
      tets_.push_back(t);
      star_of_.push_back(kNoSite);
    }
    return slot;
  }

  const KeptTetrahedralization& kept_;
  const Execution& execution_;
  Pacer pacer_;
  std::vector<SiteId> around_, sites_;  // sites added; sites reached
  std::vector<TetId> tets_;             // per tetrahedron of the part: number in the whole
  std::vector<SiteId> star_of_;         // per tetrahedron of the part: the last added site at it
  IdTable number_;                      // per tetrahedron of the whole: index in tets_
  IdTable local_;                       // per vertex of the whole that is a site of the part
  std::vector<std::uint32_t> star_;     // of the site being added: indices into tets_
};

template <class Visit>
void KeptTetrahedralization::PartMaker::add(SiteId s, const Visit& visit) {
  const TetVertexId vertex{4 + s};
  around_.push_back(s);
  star_.clear();
  const auto reach = [&](TetId t) {
    bool is_new = false;
    const std::uint32_t k = number_of(t, is_new);
    if (star_of_[k] == s) return;
    star_of_[k] = s;
    star_.push_back(k);
    if (!is_new) return;
    for (const TetVertexId v : kept_.tets_[t].v) {
      if (v < 4) continue;
      std::uint32_t& slot = local_.slot(v);
      if (slot != IdTable::kEmpty) continue;
      slot = 0;
      sites_.push_back(SiteId{v - 4});
      visit(SiteId{v - 4});
    }
  };
  reach(kept_.tet_of_vertex_[vertex]);
  for (std::size_t n = 0; n < star_.size(); ++n) {
    const Tet& tet = kept_.tets_[tets_[star_[n]]];
    for (int f = 0; f < 4; ++f)
      if (tet.v[f] != vertex && tet.n[f] != kNoTet) reach(tet.n[f]);
  }
  pacer_.step(8 * star_.size());
}

}  // namespace fracture
