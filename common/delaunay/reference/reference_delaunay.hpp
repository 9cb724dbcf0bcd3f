// The source paper's algorithms to change a tetrahedralization, on the storage of incremental.hpp: insertion
// by flips, and removal of a site. It is the readable reference, and tests compare with it. No library of the
// pipeline contains it, and no request can select it. `fracture-server bake --insertion flips` runs it.
//
// Sources: the paper's section 4 and Ledoux 2007 ("Computing the 3D Voronoi diagram robustly: an easy
// explanation") for the flips; Edelsbrunner & Shah 1996 for their termination; Devillers & Teillaud 2003
// ("Perturbations and vertex removal in a 3D Delaunay triangulation") for removal.
//
// The invariants are those of IncrementalDelaunay. All kinds of insertion may be mixed.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/delaunay/incremental.hpp"

namespace fracture {

/// Number of flips of each kind. flipMN replaces M tetrahedra by N.
struct FlipCounts {
  std::uint64_t flip14 = 0, flip26 = 0;              ///< a site inside a tetrahedron, on a facet
  std::uint64_t flip_n2n = 0;                        ///< a site on an edge of n tetrahedra
  std::uint64_t flip23 = 0, flip32 = 0, flip44 = 0;  ///< towards Delaunay
  std::uint64_t flip41 = 0;                          ///< removal of a site with four tetrahedra

  FlipCounts& operator+=(const FlipCounts& more) {
    flip14 += more.flip14;
    flip26 += more.flip26;
    flip_n2n += more.flip_n2n;
    flip23 += more.flip23;
    flip32 += more.flip32;
    flip44 += more.flip44;
    flip41 += more.flip41;
    return *this;
  }
};

class ReferenceDelaunay : public IncrementalDelaunay {
 public:
  using IncrementalDelaunay::IncrementalDelaunay;

  /// The same result as insert(), by the paper's method: flip14, flip26 or n→2n, then the queue of flip23,
  /// 32, 44.
  Insertion insert_by_flips(const Vec3d& p);
  /// Removes a site. `v` must be a live site (not a corner); otherwise throws InternalError.
  void remove(TetVertexId v);

  const FlipCounts& flips() const { return flips_; }

 private:
  // flips.cpp
  void begin_flips(TetVertexId p, const Located& at);
  void flip_around(TetVertexId p);
  int orient(const std::array<TetVertexId, 4>& v) const;
  void replace(std::span<const TetId> removed, std::span<const std::array<TetVertexId, 4>> created);
  // removal.cpp
  class Walls;
  struct LinkDelaunay;
  class StarFilling;
  void collect_star(TetVertexId v);
  LinkDelaunay tetrahedralize_link();
  void fill_star(TetVertexId v);

  FlipCounts flips_;

  // Scratch of one change, kept to avoid allocation.
  std::vector<TetId> queue_;  ///< tetrahedra at the new site whose outer facet must be checked
  std::vector<TetId> removed_;
  std::vector<std::array<TetVertexId, 4>> created_;
  struct Side {
    std::array<TetVertexId, 3> key;
    Link link;
  };
  std::vector<Side> sides_;
  std::vector<TetId> star_;         ///< the tetrahedra at the removed site
  std::vector<Facet> link_facets_;  ///< their facets opposite the site
};

/// The same result as tetrahedralize(), with every site inserted by flips. Adds the number of flips to
/// `counts`, if not null. Has the same errors; throws Interrupted.
Expected<Tetrahedralization> tetrahedralize_by_flips(std::span<const Vec3d> sites, const Box& box,
                                                     const Execution& execution,
                                                     FlipCounts* counts = nullptr);

}  // namespace fracture
