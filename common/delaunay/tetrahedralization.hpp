// Delaunay tetrahedralization of the sites inside a big tetrahedron: incremental and exact. Each site is
// inserted into a cavity (Bowyer, Watson 1981; incremental.hpp). The source paper's flips, which give the
// same tetrahedra, are in reference/.
//
// Conventions: site ids are 0..site_count()-1, in the caller's order of *distinct* points. The four corners
// of the big tetrahedron have the ids site_count()..site_count()+3. A tetrahedron (a, b, c, d) is positive:
// orient3d(a,b,c,d) > 0, with orient3d as in common/exact/orient3d.hpp. Neighbour k is opposite vertex k.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/base/id.hpp"
#include "common/base/vec.hpp"

namespace fracture {

using SiteId = Id<struct SiteTag>;
using TetId = Id<struct TetTag>;
inline constexpr TetId kNoTet{0xffffffffu};
inline constexpr SiteId kNoSite{0xffffffffu};

struct Tetrahedron {
  std::array<SiteId, 4> v;
  std::array<TetId, 4> n;  ///< neighbours; kNoTet on the hull of the big tetrahedron
};

/// Facet k of a positive tetrahedron, counter-clockwise seen from outside: (x, kFacet[k][0], [1], [2]) is
/// positive if x is on the inner side. The permutation (k, kFacet[k]...) is even.
inline constexpr std::uint8_t kFacet[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

/// The sites of the facet opposite vertex `face`, counter-clockwise seen from outside.
inline std::array<SiteId, 3> outward_facet(const Tetrahedron& t, int face) {
  const std::uint8_t* f = kFacet[face];
  return {t.v[f[0]], t.v[f[1]], t.v[f[2]]};
}

/// The finished, immutable tetrahedralization for later stages: compact, numbered without gaps.
struct Tetrahedralization {
  std::vector<Vec3d> points;  ///< sites, then the four corners
  std::vector<Tetrahedron> tets;
  std::vector<TetId> tet_of_site;  ///< some tetrahedron at each point
  /// Site id of each point in the caller's list; kNoSite if the point was dropped (it owns no point of the
  /// box).
  std::vector<SiteId> site_of_input;
  std::uint32_t duplicates_merged = 0;
  std::uint32_t far_sites_dropped = 0;

  std::uint32_t site_count() const { return static_cast<std::uint32_t>(points.size()) - 4; }
  bool is_corner(SiteId s) const { return s >= site_count(); }
};

/// Maximum absolute value of site and box coordinates.
inline constexpr double kMaxSiteCoordinate = 1e12;
/// More sites are refused (kTooComplex) before any work is done. This many need 2 GB of tetrahedra.
inline constexpr std::uint32_t kMaxSites = 4'000'000;
/// The maximum number of tetrahedra is kTetsAlways + kTetsPerSite * sites. It is checked during insertion and
/// limits both time and memory. Sites in a volume give 6.8 tetrahedra per site, and sites on a sphere 5. Two
/// skew lines of n sites each give n^2/4.
inline constexpr std::uint64_t kTetsAlways = 2'000'000;
inline constexpr std::uint64_t kTetsPerSite = 16;

/// Builds the tetrahedralization. `box` is the mesh's box (if empty, no site counts as far). The result,
/// including the numbering of the tetrahedra, is a function of the list of sites and the box; the *set* of
/// tetrahedra depends only on the set of sites and the box. For a numbering that depends only on the set of
/// tetrahedra (after local insertion or removal, for example), see canonicalize().
/// Errors: kNotFinite with "/points/<k>" (NaN, infinite or beyond kMaxSiteCoordinate), kTooComplex. Throws
/// Interrupted. Degenerate results: without sites, only the big tetrahedron; duplicates are merged into the
/// one with the lowest index.
Expected<Tetrahedralization> tetrahedralize(std::span<const Vec3d> sites, const Box& box,
                                            const Execution& execution);

/// Renumbers: sorts each tetrahedron's vertices (except for a swap of the last two that keeps it positive),
/// and the tetrahedra by vertex tuple; tet_of_site becomes the first tetrahedron. Equal sets of tetrahedra
/// with equal site ids become equal. Returns the new number of each old tetrahedron. n log n in the
/// tetrahedra of one site, otherwise linear. Not part of tetrahedralize(), because of its cost (DECISION.md).
/// Throws Interrupted.
std::vector<TetId> canonicalize(Tetrahedralization& t, const Execution& execution = kUninterrupted);

}  // namespace fracture
