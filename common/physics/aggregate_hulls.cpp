#include "common/physics/aggregate_hulls.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/base/scratch.hpp"
#include "common/physics/convex_body.hpp"
#include "common/physics/convex_parts.hpp"
#include "common/physics/divided_hulls.hpp"
#include "common/physics/hull_maker.hpp"

namespace fracture {
namespace {

/// If a rest is expected, a fragment with more than this many times the usual number of cells is a rest.
constexpr std::size_t kManyCells = 16;
/// If there are more than kFewCells cells, only the kNearCells cells nearest to a neighbour supply bisectors.
constexpr std::size_t kFewCells = 64, kNearCells = 16;
constexpr int kRounds = 4;  // of k-means; enough for a few cells
/// Relative to the extent of the cells: corners beyond a bisector by less are on it. A fraction of the least inset.
constexpr double kRounding = 4e-6;
/// The share of the distance from the largest cell's middle to its bisector that any other bisector must keep.
constexpr double kRoomToKeep = 0.5;
/// The least share of a convex part's hull that must be left after it is cut back to the cells.
constexpr double kLeastLeft = 0.5;

/// One cell's share of a fragment.
struct Share {
  std::uint32_t body;  ///< index into Fragment::bodies
  SiteId site;
  Vec3d middle;  ///< mean of the corners, local
  double size;   ///< volume of their box, m³
  std::uint32_t cluster;
};

struct Plane {
  Vec3d normal;  ///< in the local frame, not of unit length
  double offset;
  double scale;  ///< 1 / |normal|
  double height(const Vec3d& p) const { return scale * (dot(normal, p) - offset); }
};

struct Scratch {
  HullMaker maker;
  ConvexBody body;
  std::vector<Share> shares;
  std::vector<SiteId> own, neighbors;
  std::vector<Vec3d> seeds;
  std::vector<Vec3f> points;
  std::vector<const Share*> members, near;
  std::vector<std::array<std::uint32_t, 3>> triangles;

  std::size_t bytes() const {
    return maker.bytes() + body.bytes() +
           bytes_of_vectors(shares, own, neighbors, seeds, points, members, near, triangles);
  }
  void release() {
    maker.release();
    body.release();
    release_vectors(shares, own, neighbors, seeds, points, members, near, triangles);
  }
};

class FewHulls {
 public:
  FewHulls(const VoronoiDiagram& diagram, double rounding, const Execution& execution)
      : diagram_(diagram), execution_(execution), pacer_(execution), s_(thread_scratch<Scratch>()) {
    s_.maker.rounding = rounding;
  }

  /// Adds at most `most` hulls.
  void make(const Fragment& f, std::size_t most, FragmentHulls& out) {
    f_ = &f;
    find_shares(f.sites.size() > kFewCells);
    find_neighbors();
    divide(most);
    for (std::uint32_t cluster = 0; cluster < s_.seeds.size(); ++cluster) {
      s_.members.clear();
      for (const Share& share : s_.shares)
        if (share.cluster == cluster) s_.members.push_back(&share);
      if (!s_.members.empty()) add(out);
    }
  }
  /// Adds one hull for every `cells` consecutive cells of a fragment with very many. Consecutive cells are near each other,
  /// because sites are ordered along a curve through the solid. Near-linear.
  void make_of_rest(const Fragment& f, std::size_t cells, FragmentHulls& out) {
    f_ = &f;
    find_shares(true);
    find_neighbors();
    for (std::size_t first = 0; first < s_.shares.size(); first += cells) {
      s_.members.clear();
      for (std::size_t k = first; k < std::min(first + cells, s_.shares.size()); ++k)
        s_.members.push_back(&s_.shares[k]);
      add(out);
    }
  }
  /// Replaces the hulls by those of the fragment's convex parts, if the hulls close an opening. Makes one hull for each body
  /// if there are none yet.
  void keep_openings(const Fragment& f, const HullLimits& limits, FragmentHulls& out) {
    if (out.hulls.empty())
      for (const std::vector<Vec3f>& body : f.bodies) add_hull(body, {}, s_.maker, out, execution_);
    if (!may_be_divided(f) || !(out.volume > limits.excess * f.mass.volume)) return;
    collect_corners(f, s_.maker, execution_);
    const BodySurface surface(f.indices, s_.maker.corner_of);
    s_.triangles.clear();
    pacer_.each(0, surface.size(), [&](std::size_t t) { s_.triangles.push_back(surface[t]); });
    if (!close_an_opening(out.hulls, s_.maker.corners, s_.triangles, limits.excess, pacer_)) return;
    const ConvexParts parts = make_convex_parts(s_.maker.corners, s_.triangles, limits, execution_);
    f_ = &f;
    find_shares(f.sites.size() > kFewCells);
    find_neighbors();
    s_.members.clear();
    for (const Share& share : s_.shares) s_.members.push_back(&share);
    FragmentHulls made;
    made.simplified = parts.simplified;
    for (const CollisionHull& part : parts.hulls)
      if (!add_part(part, made)) return;
    if (!made.hulls.empty() && made.volume < out.volume) out = std::move(made);
  }

 private:
  const CellMap& map() const { return diagram_.map(); }
  const Vec3d& site(SiteId s) const { return diagram_.site(s); }
  /// `place` is in the fragment's local frame.
  Vec3d image(const Vec3d& place) const {
    return map() ? map().of_part(f_->part).image(place + f_->pivot) : place + f_->pivot;
  }

  /// Finds the cell of each body, which contains the mean of its corners. `walks`: walk from cell to cell, because there
  /// are too many cells to test all of them for each body.
  void find_shares(bool walks) {
    s_.shares.clear();
    VoronoiDiagram::Walk walk;
    SiteId last = f_->sites[0];
    for (std::uint32_t b = 0; b < f_->bodies.size(); ++b) {
      const std::vector<Vec3f>& body = f_->bodies[b];
      pacer_.step(body.size() + (walks ? 16 : f_->sites.size()));
      if (body.empty()) continue;
      Vec3d sum;
      Box box;
      for (const Vec3f& p : body) {
        sum = sum + to_double(p);
        box.add(to_double(p));
      }
      const Vec3d size = box.size();
      Share share{b, f_->sites[0], (1 / static_cast<double>(body.size())) * sum, size.x * size.y * size.z, 0};
      const Vec3d middle = image(share.middle);
      if (walks) last = diagram_.nearest(middle, last, walk);
      if (walks && std::binary_search(f_->sites.begin(), f_->sites.end(), last))
        share.site = last;
      else
        share.site = nearest_own(middle);
      s_.shares.push_back(share);
    }
  }
  SiteId nearest_own(const Vec3d& image) const {
    SiteId nearest = f_->sites[0];
    double least = HUGE_VAL;
    for (const SiteId s : f_->sites) {
      const Vec3d to = site(s) - image;
      if (const double square = dot(to, to); square < least) {
        least = square;
        nearest = s;
      }
    }
    return nearest;
  }

  void find_neighbors() {
    s_.neighbors.clear();
    // Only cells with a body in this fragment: other pieces of its cells may be in other fragments.
    s_.own.clear();
    for (const Share& share : s_.shares) s_.own.push_back(share.site);
    sort_with_polls(execution_, s_.own.begin(), s_.own.end());
    s_.own.erase(std::unique(s_.own.begin(), s_.own.end()), s_.own.end());
    for (const SiteId s : s_.own)
      for (const Bisector& b : diagram_.bisectors(s)) {
        pacer_.step(4);
        if (!diagram_.dual().is_corner(b.neighbor) &&
            !std::binary_search(s_.own.begin(), s_.own.end(), b.neighbor))
          s_.neighbors.push_back(b.neighbor);
      }
    sort_with_polls(execution_, s_.neighbors.begin(), s_.neighbors.end());
    s_.neighbors.erase(std::unique(s_.neighbors.begin(), s_.neighbors.end()), s_.neighbors.end());
  }

  /// Groups cells that are near each other: k-means (Lloyd 1982) with seeds far from each other (Gonzalez 1985).
  void divide(std::size_t most) {
    std::vector<Share>& shares = s_.shares;
    std::vector<Vec3d>& seeds = s_.seeds;
    seeds.clear();
    std::size_t next = 0;
    for (std::size_t k = 0; k < shares.size(); ++k)
      if (shares[k].size > shares[next].size) next = k;
    std::vector<double> far(shares.size(), HUGE_VAL);
    while (seeds.size() < std::min(most, shares.size())) {
      seeds.push_back(shares[next].middle);
      for (std::size_t k = 0; k < shares.size(); ++k) {
        pacer_.step();
        const Vec3d to = shares[k].middle - seeds.back();
        far[k] = std::min(far[k], dot(to, to));
      }
      for (std::size_t k = 0; k < shares.size(); ++k)
        if (far[k] > far[next]) next = k;
    }
    for (int round = 0; round < kRounds; ++round) {
      std::vector<Vec3d> sum(seeds.size());
      std::vector<double> weight(seeds.size(), 0);
      for (Share& share : shares) {
        pacer_.step(seeds.size());
        double least = HUGE_VAL;
        for (std::uint32_t c = 0; c < seeds.size(); ++c) {
          const Vec3d to = share.middle - seeds[c];
          if (const double square = dot(to, to); square < least) {
            least = square;
            share.cluster = c;
          }
        }
        sum[share.cluster] = sum[share.cluster] + share.middle;
        weight[share.cluster] += 1;
      }
      for (std::size_t c = 0; c < seeds.size(); ++c)
        if (weight[c] > 0) seeds[c] = (1 / weight[c]) * sum[c];
    }
  }

  /// Cell j is behind it. In the fragment's local frame: u · (x' - i) <= |u|² / 2, where x' is the image of x.
  Plane bisector(SiteId i, SiteId j) const {
    const Vec3d u = site(j) - site(i), normal = diagram_.facet_normal(i, j);
    const Vec3d pivot = map() ? map().at(site(i)).image(f_->pivot) : f_->pivot;
    return {normal, 0.5 * dot(u, u) + dot(u, site(i) - pivot), 1 / length(normal)};
  }

  /// Members whose bisectors with j are tried. Any bisector keeps cell j out; those of near members cut away least.
  std::span<const Share* const> members_near(SiteId j) {
    if (s_.members.size() <= kFewCells) return s_.members;
    pacer_.step(s_.members.size());
    const Vec3d at = site(j);
    const auto square = [&](const Share* share) {
      const Vec3d to = site(share->site) - at;
      return dot(to, to);
    };
    s_.near = s_.members;
    const auto middle = s_.near.begin() + kNearCells;
    std::nth_element(s_.near.begin(), middle, s_.near.end(), [&](const Share* a, const Share* b) {
      return std::pair(square(a), a->body) < std::pair(square(b), b->body);
    });
    s_.near.resize(kNearCells);
    return s_.near;
  }

  /// Returns the bisector of j and a member that cuts away least, and leaves room around the middle of the largest cell.
  Plane best_bisector(SiteId j, std::span<const Share* const> members, const Share& largest) const {
    Plane best = bisector(largest.site, j);
    const double room = kRoomToKeep * best.height(largest.middle);
    double least = HUGE_VAL;
    for (const Share* member : members) {
      const Plane plane = bisector(member->site, j);
      if (plane.height(largest.middle) > room && member->site != largest.site) continue;
      double taken = 0;
      for (const Vec3d& p : s_.body.corners()) taken += std::max(0.0, plane.height(p));
      if (taken < least) {
        least = taken;
        best = plane;
      }
    }
    return best;
  }

  /// Adds the hull of the members, cut back to the cells of the fragment.
  void add(FragmentHulls& out) {
    const Share* largest = s_.members[0];
    s_.points.clear();
    for (const Share* member : s_.members) {
      if (member->size > largest->size) largest = member;
      const std::vector<Vec3f>& body = f_->bodies[member->body];
      s_.points.insert(s_.points.end(), body.begin(), body.end());
    }
    const auto add_largest = [&] { add_hull(f_->bodies[largest->body], {}, s_.maker, out, execution_); };
    if (s_.members.size() == 1) return add_largest();
    const auto& triangles = s_.maker.builder.build(s_.points, kMaxHullPoints, execution_, {}, kHullTolerance);
    if (triangles.empty()) return add_largest();
    const bool simplified = s_.maker.builder.stopped_early();
    s_.body.set(s_.points, triangles);
    cut_back(*largest);
    if (!add_body(simplified, out)) add_largest();
  }

  /// Adds the hull of a convex part of the fragment, cut back to the cells of the fragment. Returns false if too little is
  /// left, or if the middle of the hull is not certain to be in one of these cells.
  bool add_part(const CollisionHull& part, FragmentHulls& out) {
    Vec3d sum;
    for (const Vec3f& p : part.points) sum = sum + to_double(p);
    const Vec3d middle = (1 / static_cast<double>(part.points.size())) * sum;
    const Share core{0, nearest_own(image(middle)), middle, 0, 0};
    if (!std::binary_search(s_.own.begin(), s_.own.end(), core.site)) return false;
    pacer_.step(s_.neighbors.size());
    if (!std::all_of(s_.neighbors.begin(), s_.neighbors.end(),
                     [&](SiteId j) { return bisector(core.site, j).height(middle) < 0; }))
      return false;
    s_.body.set(part.points, part.triangles);
    cut_back(core);
    const double before = out.volume;
    return add_body(false, out) &&
           out.volume - before > kLeastLeft * volume_within(part.points, part.triangles);
  }

  /// Cuts the body back until it meets no cell outside the fragment. Keeps the middle of `largest`, which is in its cell.
  void cut_back(const Share& largest) {
    Box box;
    for (const Vec3d& p : s_.body.corners()) box.add(p);
    const double rounding = kRounding * box.longest_side();
    const Vec3d center = box.center();
    const double radius = 0.5 * length(box.size());
    for (const SiteId j : s_.neighbors) {
      const auto is_clear = [&](SiteId i) {
        const Plane plane = bisector(i, j);
        pacer_.step(4);
        if (plane.height(center) < -radius) return true;
        pacer_.step(s_.body.corners().size());
        return plane.scale * s_.body.beyond(plane.normal, plane.offset) <= rounding;
      };
      const std::span<const Share* const> members = members_near(j);
      if (std::any_of(members.begin(), members.end(), [&](const Share* m) { return is_clear(m->site); }))
        continue;
      pacer_.step(members.size() * s_.body.corners().size());
      const Plane plane = best_bisector(j, members, largest);
      s_.body.cut(plane.normal, plane.offset, rounding / plane.scale);
    }
  }

  /// Adds the inset hull of the body. Returns false if nothing is left of the body.
  bool add_body(bool simplified, FragmentHulls& out) {
    CollisionHull hull;
    s_.body.write(hull.points, hull.triangles);
    if (hull.triangles.size() < 4) return false;
    if (hull.points.size() <= kMaxHullPoints) {
      CollisionHull smaller = hull;
      const double volume =
          inset(smaller, s_.maker.rounding);  // this also rounds corners: two may become one
      if (bounds_a_body(smaller)) {
        out.simplified += simplified;
        out.hulls.push_back(std::move(smaller));
        out.volume += volume;
        return true;
      }
    }
    add_hull(hull.points, {}, s_.maker, out, execution_);
    out.simplified += simplified && !s_.maker.builder.stopped_early();
    return true;
  }

  const VoronoiDiagram& diagram_;
  const Execution& execution_;
  Pacer pacer_;
  Scratch& s_;
  const Fragment* f_ = nullptr;
};

/// Whether its cells are in different frames, as pieces of several parts may be. Then each piece has its own hull.
bool is_in_several_frames(const Fragment& f, const VoronoiDiagram& diagram) {
  return !f.part_cells.empty() && diagram.map().frames().size() > 1;
}

}  // namespace

CollisionHulls make_aggregate_hulls(const FragmentSet& set, const VoronoiDiagram& diagram,
                                    const HullLimits& limits, std::uint32_t cells, bool has_rest,
                                    const Execution& execution, std::size_t most_of_rest) {
  CollisionHulls out;
  out.of_fragment.resize(set.fragments.size());
  parallel_for(execution, set.fragments.size(), 4, [&](std::size_t begin, std::size_t end) {
    FewHulls hulls(diagram, rounding_of(set), execution);
    for (std::size_t k = begin; k < end; ++k) {
      const Fragment& f = set.fragments[k];
      const bool has_many = f.bodies.size() > limits.count;
      if (f.bodies.size() < 2 || is_in_several_frames(f, diagram)) continue;
      if (has_rest && has_many && f.bodies.size() > kManyCells * cells) {
        if (cells > 1)
          hulls.make_of_rest(f, cells, out.of_fragment[k]);
        else if (f.bodies.size() > most_of_rest)
          hulls.make(f, most_of_rest, out.of_fragment[k]);
        continue;
      }
      if (has_many) hulls.make(f, limits.count, out.of_fragment[k]);
      // Without cuts, divide_hulls() does this: the hulls of a whole part may leave its cells.
      if (limits.count > 1 && !f.caps.empty()) hulls.keep_openings(f, limits, out.of_fragment[k]);
    }
  });
  return out;
}

}  // namespace fracture
