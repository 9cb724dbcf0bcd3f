#include "common/physics/given_hulls.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/base/disjoint_sets.hpp"
#include "common/base/pacer.hpp"
#include "common/physics/hull_maker.hpp"

namespace fracture {
namespace {

struct HullPiece {
  std::vector<Vec3f> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// The connected pieces, in the order of their first points.
std::vector<HullPiece> connected_pieces(const GivenHull& given, Pacer& pacer) {
  DisjointSets sets(given.points.size());
  for (const auto& t : given.triangles) {
    pacer.step();
    sets.unite(t[0], t[1]);
    sets.unite(t[1], t[2]);
  }
  std::vector<HullPiece> pieces;
  // The root of a set is its lowest point. So it gets its number before the others.
  std::vector<std::uint32_t> piece_of(given.points.size()), number(given.points.size());
  for (std::uint32_t p = 0; p < given.points.size(); ++p) {
    pacer.step();
    const std::uint32_t root = sets.find(p);
    if (root == p) {
      piece_of[p] = static_cast<std::uint32_t>(pieces.size());
      pieces.emplace_back();
    }
    piece_of[p] = piece_of[root];
    std::vector<Vec3f>& points = pieces[piece_of[p]].points;
    number[p] = static_cast<std::uint32_t>(points.size());
    points.push_back(given.points[p]);
  }
  for (const auto& t : given.triangles) {
    pacer.step();
    pieces[piece_of[t[0]]].triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
  }
  return pieces;
}

}  // namespace

FragmentHulls make_given_hulls(const GivenHull& given, double most_excess, const Execution& execution) {
  Pacer pacer(execution);
  FragmentHulls made;
  ConvexHullBuilder builder;
  std::vector<std::uint32_t> index;
  for (const HullPiece& piece : connected_pieces(given, pacer)) {
    const ConvexHullBuilder::Triangles& triangles = builder.build(piece.points, kMaxHullPoints, execution);
    if (triangles.empty()) {
      if (!given.convex) return {};
      continue;
    }
    CollisionHull hull = compact(piece.points, triangles, index);
    const double volume = volume_within(hull.points, hull.triangles);
    if (!given.convex && !(volume <= most_excess * std::fabs(volume_within(piece.points, piece.triangles))))
      return {};
    made.simplified += builder.stopped_early();
    made.volume += volume;
    made.hulls.push_back(std::move(hull));
  }
  return made;
}

}  // namespace fracture
