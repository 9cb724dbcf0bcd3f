#include "common/delaunay/kept_tetrahedralization.hpp"

#include <numeric>
#include <tuple>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/delaunay/box_distance.hpp"
#include "common/delaunay/spatial_order.hpp"
#include "common/exact/in_sphere.hpp"

namespace fracture {
namespace {

std::uint32_t most_tets(std::uint64_t sites) {
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(kTetsAlways + kTetsPerSite * sites, 0x3ffffff0u));
}

/// Makes negative zeros positive, so that equal points have equal bits.
Vec3d plain(const Vec3d& p) { return {p.x + 0.0, p.y + 0.0, p.z + 0.0}; }

/// A facet between new tetrahedra and those that stay.
struct RimFacet {
  std::array<TetVertexId, 3> key;  // ascending
  TetId tet;
  int face;
};
RimFacet rim_facet(const std::array<TetVertexId, 4>& v, TetId tet, int face) {
  RimFacet facet{{v[kFacet[face][0]], v[kFacet[face][1]], v[kFacet[face][2]]}, tet, face};
  std::sort(facet.key.begin(), facet.key.end());
  return facet;
}

}  // namespace

std::optional<KeptTetrahedralization> KeptTetrahedralization::of(const Tetrahedralization& whole,
                                                                 const Box& box, const Execution& execution) {
  if (box.empty()) return std::nullopt;
  KeptTetrahedralization kept(box);
  Box domain = box;
  const std::uint32_t sites = whole.site_count();
  const auto vertex = [sites](SiteId s) { return TetVertexId{s < sites ? 4 + s : s - sites}; };
  std::vector<Vec3d> points(whole.points.size());
  std::vector<TetId> tet_of_vertex(points.size());
  Pacer pacer(execution);
  for (const SiteId s : ids<SiteId>(points.size())) {
    pacer.step();
    const Vec3d p = plain(whole.points[s]);
    if (s < sites) {
      domain.add(p);
      kept.farthest_outside2_ = std::max(kept.farthest_outside2_, delaunay_detail::nearest2(box, p));
    }
    kept.scale_.include(p);
    points[vertex(s)] = p;
    tet_of_vertex[vertex(s)] = whole.tet_of_site[s];
  }
  kept.big_ = big_tetrahedron(domain);
  std::vector<Tet> tets;
  resize_with_polls(execution, tets, whole.tets.size());
  pacer.each(0, tets.size(), [&](std::size_t t) {
    const Tetrahedron& from = whole.tets[t];
    tets[t] = {{vertex(from.v[0]), vertex(from.v[1]), vertex(from.v[2]), vertex(from.v[3])}, from.n};
  });
  kept.points_ = SharedBlocks<Vec3d>(std::move(points));
  kept.tet_of_vertex_ = SharedBlocks<TetId, 256>(std::move(tet_of_vertex));
  kept.tets_ = SharedBlocks<Tet>(std::move(tets));
  kept.given_ = whole.site_of_input.size() - whole.far_sites_dropped;
  kept.duplicates_merged_ = whole.duplicates_merged;
  return kept;
}

/// The same walk as IncrementalDelaunay::walk(), but with a fixed start for the random numbers.
TetId KeptTetrahedralization::locate(const Vec3d& p, TetId t) const {
  std::uint64_t random = 0x853c49e6748fea9bull;
  TetId came = kNoTet;
  for (;;) {
    const Tet& tet = tets_[t];
    random = random * 6364136223846793005ull + 1442695040888963407ull;
    const unsigned first = random >> 62;
    TetId next = t;
    for (unsigned i = 0; i < 4 && next == t; ++i) {
      const unsigned k = (first + i) & 3;
      const std::uint8_t* f = kFacet[k];
      if (tet.n[k] == kNoTet || tet.n[k] == came) continue;
      if (orient3d(p, at(tet.v[f[0]]), at(tet.v[f[1]]), at(tet.v[f[2]])) < 0) next = tet.n[k];
    }
    if (next == t) return t;
    came = t;
    t = next;
  }
}

/// Jump and walk (Mücke, Saias & Zhu 1999): starts at the nearest among a sample of the sites.
TetId KeptTetrahedralization::start_near(const Vec3d& p) const {
  constexpr std::uint32_t kLookedAt = 64;
  const std::uint32_t sites = site_count(), stride = 1 + sites / kLookedAt;
  TetVertexId best{0};
  double least = HUGE_VAL;
  for (std::uint32_t s = 0; s < sites; s += stride) {
    const Vec3d d = at(TetVertexId{4 + s}) - p;
    if (const double distance2 = dot(d, d); distance2 < least) {
      least = distance2;
      best = TetVertexId{4 + s};
    }
  }
  return tet_of_vertex_[best];
}

/// The tetrahedra in conflict with some points, and the points that are not vertices yet.
struct KeptTetrahedralization::Conflicts {
  std::vector<TetId> tets;
  IdTable number;                    // per such tetrahedron: its index in `tets`
  std::vector<std::uint32_t> fresh;  // indices of points, in the order of insertion
  std::vector<TetVertexId> near;     // per fresh point: a corner of the tetrahedron that contained it
  std::vector<std::uint32_t> rank;   // per point: rank of its index in `fresh`, or kNoIndex

  Conflicts(const KeptTetrahedralization& kept, std::span<const Vec3d> points, const Execution& execution) {
    Pacer pacer(execution);
    std::vector<std::uint32_t> order(points.size());
    std::iota(order.begin(), order.end(), 0u);
    sort_with_polls(execution, order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      return points[a] == points[b] ? a < b : lexicographic_less(points[a], points[b]);
    });
    rank.assign(points.size(), kNoIndex);
    std::vector<char> is_first(points.size(), 0);
    for (std::size_t k = 0; k < order.size(); ++k)
      is_first[order[k]] = k == 0 || points[order[k]] != points[order[k - 1]];

    IdTable tested;  // per tetrahedron: the last point that it was tested with
    TetId start = points.empty() ? kNoTet : kept.start_near(points[0]);
    for (const std::uint32_t k : spatial_order(points, execution)) {
      const Vec3d& p = points[k];
      start = kept.locate(p, start);
      pacer.step(64);
      const auto& corners = kept.tets_[start].v;
      if (!is_first[k] ||
          std::any_of(corners.begin(), corners.end(), [&](TetVertexId v) { return kept.at(v) == p; }))
        continue;
      fresh.push_back(k);
      near.push_back(corners[0]);
      std::vector<TetId> found{start};
      tested.slot(start) = k;
      for (std::size_t n = 0; n < found.size(); ++n) {
        const TetId t = found[n];
        pacer.step(32);
        if (std::uint32_t& slot = number.slot(t); slot == IdTable::kEmpty) {
          slot = static_cast<std::uint32_t>(tets.size());
          tets.push_back(t);
        }
        for (const TetId u : kept.tets_[t].n) {
          if (u == kNoTet) continue;
          std::uint32_t& last = tested.slot(u);
          if (last == k) continue;
          last = k;
          const auto& v = kept.tets_[u].v;
          if (exact::in_sphere(kept.at(v[0]), kept.at(v[1]), kept.at(v[2]), kept.at(v[3]), p) > 0)
            found.push_back(u);
        }
      }
    }
    for (const std::uint32_t k : fresh) rank[k] = 0;
    std::uint32_t next = 0;
    for (std::uint32_t& r : rank)
      if (r != kNoIndex) r = next++;
  }
};

std::optional<KeptTetrahedralization::Insertion> KeptTetrahedralization::insert(
    std::span<const Vec3d> further, const Execution& execution) {
  std::vector<Vec3d> points;
  for (const Vec3d& p : further) {
    if (!(delaunay_detail::nearest2(box_, p) == 0) ||
        !delaunay_detail::is_near_enough(farthest_outside2_, delaunay_detail::farthest2(box_, p)))
      return std::nullopt;
    points.push_back(plain(p));
    scale_.include(p);
  }
  given_ += points.size();
  const std::uint32_t limit = most_tets(given_);
  if (given_ > kMaxSites) return std::nullopt;
  const Conflicts conflicts(*this, points, execution);
  duplicates_merged_ += static_cast<std::uint32_t>(points.size() - conflicts.fresh.size());
  Insertion done;
  if (conflicts.fresh.empty()) return done;
  Pacer pacer(execution);

  // The removed tetrahedra as a separate tetrahedralization. Its sites keep their order.
  const std::uint32_t before = site_count();
  std::vector<TetVertexId> vertices;  // per site of the region
  for (const TetId t : conflicts.tets)
    for (const TetVertexId v : tets_[t].v)
      if (v >= 4) vertices.push_back(v);
  sort_with_polls(execution, vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  const auto local = [&](TetVertexId v) {
    if (v < 4) return SiteId{vertices.size() + v};
    return SiteId{std::lower_bound(vertices.begin(), vertices.end(), v) - vertices.begin()};
  };
  Tetrahedralization region;
  for (const TetVertexId v : vertices) region.points.push_back(at(v));
  for (const TetVertexId corner : ids<TetVertexId>(4)) region.points.push_back(at(corner));
  std::vector<RimFacet> rim;  // of the tetrahedra that stay
  for (const TetId t : conflicts.tets) {
    pacer.step(32);
    const Tet& tet = tets_[t];
    Tetrahedron& of_region = region.tets.emplace_back();
    for (int k = 0; k < 4; ++k) {
      of_region.v[k] = local(tet.v[k]);
      const std::uint32_t neighbor = tet.n[k] == kNoTet ? kNoIndex : conflicts.number.find(tet.n[k]);
      of_region.n[k] = TetId{neighbor};
      if (neighbor != kNoIndex || tet.n[k] == kNoTet) continue;
      const auto& back = tets_[tet.n[k]].n;
      RimFacet& behind = rim.emplace_back(rim_facet(tet.v, tet.n[k], k));
      behind.face = static_cast<int>(std::find(back.begin(), back.end(), t) - back.begin());
    }
  }

  IncrementalDelaunay delaunay(big_, {limit, &execution}, region);
  std::vector<SiteId> site_of_vertex(4 + vertices.size() + conflicts.fresh.size(), kNoSite);
  for (const SiteId s : ids<SiteId>(vertices.size())) site_of_vertex[4 + s] = s;
  for (std::size_t n = 0; n < conflicts.fresh.size(); ++n) {
    pacer.step(1024);
    const std::uint32_t k = conflicts.fresh[n];
    // The straight line from a corner of its tetrahedron to the point is inside the region.
    const SiteId from = local(conflicts.near[n]);
    const TetVertexId near{from < vertices.size() ? 4 + from : from - vertices.size()};
    const auto [status, vertex] = delaunay.insert_in_part(points[k], near);
    if (status == IncrementalDelaunay::Status::kFull) return std::nullopt;
    site_of_vertex[vertex] = SiteId{vertices.size() + conflicts.rank[k]};
  }
  const Tetrahedralization filled = delaunay.snapshot(site_of_vertex);
  execution.made(Product::kTetrahedra, filled.tets.size());
  if (tet_count() - conflicts.tets.size() + filled.tets.size() > limit) return std::nullopt;

  // The new tetrahedra first reuse the numbers of the removed ones.
  SharedBlocks<Tet>::Edit tets(tets_);
  SharedBlocks<TetId, 256>::Edit tet_of_vertex(tet_of_vertex_);
  {
    SharedBlocks<Vec3d>::Edit all(points_);
    done.points = conflicts.fresh;
    std::sort(done.points.begin(), done.points.end());
    for (const std::uint32_t k : done.points) {
      all.push_back(points[k]);
      tet_of_vertex.push_back(kNoTet);
    }
  }
  done.gone = conflicts.tets;
  std::vector<TetId> slots = conflicts.tets;
  for (std::size_t k = slots.size(); k > filled.tets.size();) {
    tets.at(slots[--k]).v[0] = kNoVertex;
    free_.push_back(slots[k]);
    slots.pop_back();
  }
  while (slots.size() < filled.tets.size()) {
    if (free_.empty()) {
      slots.push_back(TetId{tets_.size()});
      tets.push_back({});
    } else {
      slots.push_back(free_.back());
      free_.pop_back();
    }
  }
  const std::uint32_t region_sites = filled.site_count();
  const auto vertex = [&](SiteId s) {
    if (s >= region_sites) return TetVertexId{s - region_sites};
    return s < vertices.size() ? vertices[s] : TetVertexId{4 + before + (s - vertices.size())};
  };
  std::vector<RimFacet> fresh_rim;
  for (const TetId t : ids<TetId>(filled.tets.size())) {
    pacer.step(16);
    const Tetrahedron& from = filled.tets[t];
    Tet& to = tets.at(slots[t]);
    for (int k = 0; k < 4; ++k) {
      to.v[k] = vertex(from.v[k]);
      to.n[k] = from.n[k] == kNoTet ? kNoTet : slots[from.n[k]];
      tet_of_vertex.at(to.v[k]) = slots[t];
    }
    for (int k = 0; k < 4; ++k)
      if (to.n[k] == kNoTet) fresh_rim.push_back(rim_facet(to.v, slots[t], k));
  }
  const auto by_key = [](const RimFacet& a, const RimFacet& b) { return a.key < b.key; };
  sort_with_polls(execution, rim.begin(), rim.end(), by_key);
  sort_with_polls(execution, fresh_rim.begin(), fresh_rim.end(), by_key);
  std::size_t k = 0;
  for (const RimFacet& facet : fresh_rim) {  // facets of the big tetrahedron have no neighbour
    if (k == rim.size() || rim[k].key != facet.key) continue;
    tets.at(facet.tet).n[facet.face] = rim[k].tet;
    tets.at(rim[k].tet).n[rim[k].face] = facet.tet;
    ++k;
  }
  if (k != rim.size()) throw InternalError("the new tetrahedra do not fill the space of the removed ones");
  done.made = std::move(slots);
  return done;
}

SiteId KeptTetrahedralization::Part::local(SiteId s) const {
  return SiteId{std::lower_bound(sites.begin(), sites.end(), s) - sites.begin()};
}

KeptTetrahedralization::Part KeptTetrahedralization::PartMaker::finish() {
  Part part;
  part.sites = std::move(sites_);
  sort_with_polls(execution_, part.sites.begin(), part.sites.end());
  Tetrahedralization& out = part.tetrahedra;
  const auto sites = static_cast<std::uint32_t>(part.sites.size());
  out.points.reserve(sites + 4);
  for (std::uint32_t s = 0; s < sites; ++s) {
    local_.slot(4 + part.sites[s]) = s;
    out.points.push_back(kept_.site(part.sites[s]));
  }
  for (const TetVertexId corner : ids<TetVertexId>(4)) {
    local_.slot(corner) = sites + corner;
    out.points.push_back(kept_.at(corner));
  }
  out.tet_of_site.assign(out.points.size(), kNoTet);
  out.tets.reserve(tets_.size());
  for (const TetId t : tets_) {
    pacer_.step(8);
    const Tet& from = kept_.tets_[t];
    Tetrahedron& tet = out.tets.emplace_back();
    for (int k = 0; k < 4; ++k) {
      tet.v[k] = SiteId{local_.find(from.v[k])};
      tet.n[k] = from.n[k] == kNoTet ? kNoTet : TetId{number_.find(from.n[k])};
    }
  }
  part.whole.assign(sites, 0);
  for (const SiteId s : around_) part.whole[local_.find(4 + s)] = 1;
  const std::vector<TetId> now = canonicalize(out, execution_);
  part.tets.resize(tets_.size());
  for (std::size_t t = 0; t < tets_.size(); ++t) part.tets[now[t]] = tets_[t];
  return part;
}

}  // namespace fracture
