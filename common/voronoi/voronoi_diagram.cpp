#include "common/voronoi/voronoi_diagram.hpp"

#include <algorithm>
#include <string>

#include "common/base/error.hpp"
#include "common/base/pacer.hpp"
#include "common/base/stamped_map.hpp"
#include "common/exact/side.hpp"

namespace fracture {

VoronoiDiagram::VoronoiDiagram(const Tetrahedralization& tetrahedralization, const Box& box,
                               const CellMap& map, const Execution& execution, std::size_t many)
    : dual_(&tetrahedralization), map_(map), many_(many), all_sites_(std::make_unique<AllSites>()) {
  build(box, nullptr, execution);
}

VoronoiDiagram::VoronoiDiagram(const Tetrahedralization& part, const std::vector<char>& cells, const Box& box,
                               const CellMap& map, const Execution& execution, std::size_t many)
    : dual_(&part), map_(map), many_(many), all_sites_(std::make_unique<AllSites>()) {
  build(box, &cells, execution);
}

void VoronoiDiagram::build(const Box& box, const std::vector<char>* cells, const Execution& execution) {
  const std::uint32_t sites = dual_->site_count();

  const auto has_cell = [&](SiteId s) { return s < sites && (!cells || (*cells)[s]); };

  // Group tetrahedra by site (counting sort), except for corners, whose cells contain no point of the box.
  Pacer pacer(execution);
  tet_begin_.assign(sites + 1, 0);
  for (const Tetrahedron& t : dual_->tets) {
    pacer.step();
    for (const SiteId s : t.v)
      if (has_cell(s)) ++tet_begin_[s + 1];
  }
  // A site's tetrahedra form the triangles of a sphere whose vertices are its neighbours (Euler: F = 2V - 4).
  bisector_begin_.assign(sites + 1, 0);
  for (const SiteId s : ids<SiteId>(sites)) {
    bisector_begin_[s + 1] = bisector_begin_[s] + (has_cell(s) ? tet_begin_[s + 1] / 2 + 2 : 0);
    tet_begin_[s + 1] += tet_begin_[s];
  }
  resize_with_polls(execution, tets_, tet_begin_[sites]);
  std::vector<std::uint32_t> next(tet_begin_.begin(), tet_begin_.end() - 1);
  for (const TetId t : ids<TetId>(dual_->tets.size())) {
    pacer.step();
    for (const SiteId s : dual_->tets[t].v)
      if (has_cell(s)) tets_[next[s]++] = t;
  }

  resize_with_polls(execution, bisectors_, bisector_begin_[sites]);
  constexpr std::size_t kBlock = 256;
  parallel_for(execution, sites, kBlock, [&](std::size_t begin, std::size_t end) {
    StampedMap& first_tet = worker_map();
    std::vector<SiteId> neighbors;
    Pacer own_pacer(execution);
    for (const SiteId i : ids<SiteId>(begin, end)) {
      if (!has_cell(i)) continue;
      first_tet.next_epoch(sites + 4);
      first_tet.slot(i) = 0;
      neighbors.clear();
      for (const TetId t : tetrahedra(i))
        for (const SiteId s : dual_->tets[t].v)
          if (first_tet.slot(s) == StampedMap::kEmpty) {
            first_tet.slot(s) = t;
            neighbors.push_back(s);
          }
      own_pacer.step(neighbors.size());
      if (neighbors.size() != bisector_begin_[i + 1] - bisector_begin_[i])
        throw InternalError("the tetrahedra at site " + std::to_string(i) + " do not form a ball");
      std::sort(neighbors.begin(), neighbors.end());

      // Rounding of value(): every difference and product has a relative error of 2^-53, and |q - p_i| is at
      // most `reach` on each axis. Fewer than 16 roundings affect any term. With gradual underflow, its
      // products also lose at most 2^-1075 each, and so do those of this bound. There are fewer than 16, and
      // 2^-1000 is more.
      const Vec3d& p = site(i);
      double reach = 0;
      for (int a = 0; a < 3; ++a)
        reach = std::max({reach, std::fabs(box.max[a] - p[a]), std::fabs(box.min[a] - p[a])});
      Bisector* out = bisectors_.data() + bisector_begin_[i];
      for (const SiteId j : neighbors) {
        const Vec3d u = site(j) - p;
        const double half = 0.5 * dot(u, u);
        const double norm1 = std::fabs(u.x) + std::fabs(u.y) + std::fabs(u.z);
        *out++ = {u, half, 0x1.0p-49 * (half + norm1 * reach) + 0x1p-1000, j, TetId{first_tet.slot(j)}};
      }
    }
  });

  for (const SiteId i : ids<SiteId>(sites)) {
    if (!has_many_neighbors(i)) continue;
    execution.poll();
    add_neighborhood(i);
  }
}

void VoronoiDiagram::add_neighborhood(SiteId i) {
  const auto all = bisectors(i);
  std::vector<Vec3d> points;
  for (const Bisector& b : all) points.push_back(site(b.neighbor));
  Neighborhood n{i, SiteTree(points), {}, {}};
  // The tetrahedra at the site form the triangles of a sphere. Each edge of the sphere is in two triangles,
  // once in each direction.
  const auto each = [&](const auto& visit) {
    for (const TetId t : tetrahedra(i)) {
      const auto& v = dual_->tets[t].v;
      const int at = static_cast<int>(std::find(v.begin(), v.end(), i) - v.begin());
      std::uint32_t facet[3];
      for (int k = 0; k < 3; ++k)
        facet[k] = static_cast<std::uint32_t>(find_bisector(i, v[kFacet[at][k]]) - all.data());
      for (int k = 0; k < 3; ++k) visit(facet[k], facet[(k + 1) % 3]);
    }
  };
  n.begin.assign(all.size() + 1, 0);
  each([&](std::uint32_t a, std::uint32_t) { ++n.begin[a + 1]; });
  for (std::size_t k = 0; k < all.size(); ++k) n.begin[k + 1] += n.begin[k];
  n.adjacent.resize(n.begin.back());
  std::vector<std::uint32_t> next(n.begin.begin(), n.begin.end() - 1);
  each([&](std::uint32_t a, std::uint32_t b) { n.adjacent[next[a]++] = b; });
  neighborhoods_.push_back(std::move(n));
}

int VoronoiDiagram::side(SiteId i, const Bisector& bisector, const Vec3d& q) const {
  const double v = value(i, bisector, q);
  if (v > bisector.error) return 1;
  if (v < -bisector.error) return -1;
  return exact::side1(site(i), site(bisector.neighbor), q);
}

const Neighborhood& VoronoiDiagram::neighborhood(SiteId i) const {
  return *std::lower_bound(neighborhoods_.begin(), neighborhoods_.end(), i,
                           [](const Neighborhood& n, SiteId s) { return n.site < s; });
}

SiteId VoronoiDiagram::closer_neighbor(const Vec3d& q, SiteId i, Walk& walk) const {
  walk.looked_at += bisectors(i).size();
  // Find the most violated bisector: by value, this is the steepest descent in squared distance.
  double worst = 0;
  SiteId next = kNoSite;
  bool doubt = false;
  for (const Bisector& b : bisectors(i)) {
    const double v = value(i, b, q);
    if (v < -b.error) {
      if (v < worst) {
        worst = v;
        next = b.neighbor;
      }
    } else if (v <= b.error) {
      doubt = true;
    }
  }
  if (next == kNoSite && doubt)
    for (const Bisector& b : bisectors(i))
      if (std::fabs(value(i, b, q)) <= b.error && exact::side1(site(i), site(b.neighbor), q) < 0)
        return b.neighbor;
  return next;
}

SiteId VoronoiDiagram::closer_of_many(const Vec3d& q, SiteId i, Walk& walk) const {
  if (walk.cell != i) walk = {i, 0, walk.looked_at};
  const auto value_at_q = [&](const Bisector& b) { return Certified{value(i, b, q), b.error}; };
  switch (neighborhood(i).shoot_ray(bisectors(i), value_at_q, {}, walk.facet, walk.looked_at)) {
    case Neighborhood::RayAnswer::kInside:
      return kNoSite;
    case Neighborhood::RayAnswer::kOutside:
      return bisectors(i)[walk.facet].neighbor;
    case Neighborhood::RayAnswer::kUncertain:
      break;
  }
  SiteId next = kNoSite;
  bool doubt = false;
  double radius2 = reach2(i, q);
  visit_near(i, q, radius2, [&](const Bisector& b, double distance2) {
    ++walk.looked_at;
    const double v = value(i, b, q);
    if (v < -b.error) {
      next = b.neighbor;
      radius2 = distance2;
    } else {
      doubt |= v <= b.error;
    }
    return radius2;
  });
  if (next == kNoSite && doubt)
    visit_near(i, q, radius2, [&](const Bisector& b, double) {
      if (next == kNoSite && value(i, b, q) <= b.error && exact::side1(site(i), site(b.neighbor), q) < 0)
        next = b.neighbor;
      return next == kNoSite ? radius2 : -1;
    });
  return next;
}

SiteId VoronoiDiagram::roughly_nearest(const Vec3d& q) const {
  std::call_once(all_sites_->once,
                 [&] { all_sites_->tree.emplace(std::span(dual_->points).first(dual_->site_count())); });
  SiteId best{0};
  all_sites_->tree->visit_near(q, HUGE_VAL, [&](std::uint32_t s, double distance2) {
    best = SiteId{s};
    return distance2;
  });
  return best;
}

SiteId VoronoiDiagram::nearest(const Vec3d& q, SiteId start, Walk& walk) const {
  // In a (perturbed, hence generic) power diagram, a site that is nearer than all its neighbours is the
  // nearest one. Each step comes strictly closer, so the walk ends. For sites in a volume, the walk takes one
  // step per cell on the way. So many steps are rare, unless each point is far from the previous one.
  constexpr int kLongWalk = 32;
  const auto is_lost = [&](int steps) {
    return steps > 0 && steps % kLongWalk == 0 &&
           all_sites_->steps.fetch_add(kLongWalk, std::memory_order_relaxed) > dual_->site_count();
  };
  SiteId i = start;
  bool jumped = false;
  for (int steps = 0;; ++steps) {
    const SiteId next = has_many_neighbors(i) ? closer_of_many(q, i, walk) : closer_neighbor(q, i, walk);
    if (next == kNoSite) return i;
    if (dual_->is_corner(next))
      throw InternalError("nearest: a point of the box lies in the cell of a corner");
    const bool jump = !jumped && is_lost(steps);
    i = jump ? roughly_nearest(q) : next;
    jumped |= jump;
  }
}

const Bisector* VoronoiDiagram::find_bisector(SiteId i, SiteId j) const {
  const auto all = bisectors(i);
  const auto at =
      std::lower_bound(all.begin(), all.end(), j, [](const Bisector& b, SiteId s) { return b.neighbor < s; });
  return at != all.end() && at->neighbor == j ? &*at : nullptr;
}

VoronoiDiagram::Facet VoronoiDiagram::find_facet(SiteId i, SiteId j, SiteId k) const {
  // Turn around edge (i, a): leave each tetrahedron through the facet opposite the vertex that the previous
  // tetrahedron did not have.
  struct Sweep {
    SiteId i, a, wanted;
    TetId first, at;
    SiteId before = kNoSite;  // the vertex of `at` to turn away from
    bool done = false;
  };
  const auto next_facet = [&](Sweep& turn) -> std::optional<Facet> {
    const Tetrahedron& t = dual_->tets[turn.at];
    int others[2], n = 0, found = -1;
    for (int m = 0; m < 4; ++m)
      if (t.v[m] != turn.i && t.v[m] != turn.a) {
        if (n == 2) throw InternalError("a tetrahedron is not at the edge it turns around");
        others[n++] = m;
        if (t.v[m] == turn.wanted) found = m;
      }
    if (found >= 0) return Facet{turn.at, others[0] == found ? others[1] : others[0]};
    const int away = t.v[others[0]] == turn.before || turn.before == kNoSite ? 0 : 1;
    turn.before = t.v[others[1 - away]];
    turn.at = t.n[others[away]];
    turn.done = turn.at == turn.first || turn.at == kNoTet;
    return std::nullopt;
  };
  const Bisector *to_j = find_bisector(i, j), *to_k = find_bisector(i, k);
  if (to_j && to_k) {
    Sweep about_j{i, j, k, to_j->tet, to_j->tet}, about_k{i, k, j, to_k->tet, to_k->tet};
    while (!about_j.done && !about_k.done) {
      if (const auto facet = next_facet(about_j)) return *facet;
      if (const auto facet = next_facet(about_k)) return *facet;
    }
  }
  throw InternalError("no Delaunay facet (" + std::to_string(i) + ", " + std::to_string(j) + ", " +
                      std::to_string(k) + ")");
}

}  // namespace fracture
