#include "common/physics/convex_parts.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/disjoint_sets.hpp"
#include "common/base/id.hpp"
#include "common/base/pacer.hpp"
#include "common/base/scratch.hpp"
#include "common/physics/convex_hull.hpp"
#include "common/physics/hull_maker.hpp"
#include "common/physics/notches.hpp"
#include "common/physics/polyhedron.hpp"

namespace fracture {
namespace {

using TriangleSpan = std::span<const std::array<std::uint32_t, 3>>;

/// Number of planes tried for each cut. With 8, a square frame takes a fifth less, but some solids get larger hulls.
constexpr std::size_t kTried = 10;
/// Points and tolerance (kHullTolerance) of hulls that only compare planes. With 24 points, cuts of round parts are worse.
constexpr std::uint32_t kTrialPoints = 48;
constexpr double kTrialTolerance = 0.02;
/// The cost of a cut is the volume of the resulting hulls, relative to the hull of the part, plus these terms. Remaining
/// excesses count by the root of the sum of their squares, because the first cuts of a ring gain nothing: two halves are then
/// better than a slice and the rest.
constexpr double kLeftCost = 0.5;
/// Weights of the plane's votes, the cut's area relative to the hull's surface, and each body beyond two.
constexpr double kVotesWorth = 0.2, kAreaCost = 0.3, kBodyCost = 0.1;
/// Parts are merged if their common hull is larger than their hulls together by less than this share of its volume, or if it
/// has less than this share of the allowed excess.
constexpr double kFreeMerge = 0.02, kMergedExcess = 0.5;
/// Number of parts made before merging, as a multiple of the number of hulls.
constexpr std::size_t kPartsPerHull = 2;
/// Corners this near to a plane count as on it, relative to the size of the solid: ten steps of floats.
constexpr double kOnPlane = 1e-6;

struct ConvexPiece {
  Polyhedron solid;  ///< if parts were merged: the first one's
  double volume = 0;
  std::vector<Vec3f> corners;  ///< all points that its hull must contain
  Box box;
  CollisionHull hull;
  double hull_volume = 0, hull_area = 0;
  bool is_simplified = false;
  bool is_done = false;  ///< convex enough, or cannot be divided
};

struct PartsScratch {
  ConvexHullBuilder builder;
  PolyhedronCutter cutter;
  NotchPlanes notches;
  std::vector<Vec3f> points;
  std::vector<std::uint32_t> number;

  std::size_t bytes() const {
    return builder.bytes() + cutter.bytes() + notches.bytes() + bytes_of_vectors(points, number);
  }
  void release() {
    builder.release();
    cutter.release();
    notches.release();
    release_vectors(points, number);
  }
};

Vec3f to_float(const Vec3d& p) {
  return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}

class Decomposition {
 public:
  Decomposition(const HullLimits& limits, const Execution& execution)
      : limits_(limits), execution_(execution), pacer_(execution), s_(thread_scratch<PartsScratch>()) {}

  ConvexParts run(std::span<const Vec3f> points, TriangleSpan triangles);

 private:
  void add_shells(std::span<const Vec3f> points, TriangleSpan triangles);
  double trial_volume(std::span<const Vec3d> points);
  void make_hull(ConvexPiece& part);
  void finish(ConvexPiece& part);
  double cost(const ConvexPiece& part, const NotchPlanes::Candidate& candidate, double most);
  bool split(std::size_t k);
  std::size_t worst() const;
  double common_volume(const ConvexPiece& a, const ConvexPiece& b);
  bool touch(const ConvexPiece& a, const ConvexPiece& b) const;
  bool may_merge(const ConvexPiece& a, const ConvexPiece& b, double common) const;
  void merge();

  const HullLimits limits_;
  const Execution& execution_;
  Pacer pacer_;
  PartsScratch& s_;
  double size_ = 0, on_plane_ = 0;
  std::vector<ConvexPiece> parts_;
};

/// Adds one part for each outward shell. Inward shells are cavities, which are left out.
void Decomposition::add_shells(std::span<const Vec3f> points, TriangleSpan triangles) {
  DisjointSets shells(points.size());
  for (const auto& t : triangles) {
    pacer_.step();
    shells.unite(t[0], t[1]);
    shells.unite(t[0], t[2]);
  }
  std::vector<std::uint32_t> part_of(points.size(), kNoIndex);
  s_.number.assign(points.size(), kNoIndex);
  for (const auto& t : triangles) {
    pacer_.step(4);
    const std::uint32_t root = shells.find(t[0]);
    if (part_of[root] == kNoIndex) {
      part_of[root] = static_cast<std::uint32_t>(parts_.size());
      parts_.emplace_back();
    }
    Polyhedron& solid = parts_[part_of[root]].solid;
    for (const std::uint32_t v : t)
      if (s_.number[v] == kNoIndex) {
        s_.number[v] = static_cast<std::uint32_t>(solid.points.size());
        solid.points.push_back(to_double(points[v]));
      }
    const Vec3d a = to_double(points[t[0]]);
    const Vec3d n = cross(to_double(points[t[1]]) - a, to_double(points[t[2]]) - a);
    const double l = length(n);
    for (std::size_t k = 0; k < 3; ++k)
      solid.edges.push_back({s_.number[t[k]], s_.number[t[k == 2 ? 0 : k + 1]]});
    solid.faces.push_back({static_cast<std::uint32_t>(solid.edges.size()), l > 0 ? (1 / l) * n : Vec3d{}});
  }
  for (ConvexPiece& part : parts_) part.volume = volume_of(part.solid, pacer_);
  std::erase_if(parts_, [](const ConvexPiece& p) { return !(p.volume > 0); });
}

/// The volume of the points' hull, slightly too small; 0 if they are flat.
double Decomposition::trial_volume(std::span<const Vec3d> points) {
  s_.points.clear();
  pacer_.each(0, points.size(), [&](std::size_t k) { s_.points.push_back(to_float(points[k])); });
  return volume_within(s_.points, s_.builder.build(s_.points, kTrialPoints, execution_, {}, kTrialTolerance));
}

/// Makes the hull of the corners. Flat corners get neither a hull nor a volume.
void Decomposition::make_hull(ConvexPiece& part) {
  const auto& triangles = s_.builder.build(part.corners, kMaxHullPoints, execution_, {}, kHullTolerance);
  part.is_simplified = s_.builder.stopped_early();
  part.hull = {};
  s_.number.assign(part.corners.size(), kNoIndex);
  for (const auto& t : triangles)
    for (const std::uint32_t v : t) s_.number[v] = 0;
  for (std::size_t k = 0; k < part.corners.size(); ++k)
    if (s_.number[k] == 0) {
      s_.number[k] = static_cast<std::uint32_t>(part.hull.points.size());
      part.hull.points.push_back(part.corners[k]);
    }
  part.hull_area = 0;
  for (const auto& t : triangles) {
    part.hull.triangles.push_back({s_.number[t[0]], s_.number[t[1]], s_.number[t[2]]});
    const Vec3d a = to_double(part.corners[t[0]]);
    part.hull_area +=
        0.5 * length(cross(to_double(part.corners[t[1]]) - a, to_double(part.corners[t[2]]) - a));
  }
  part.hull_volume = volume_within(part.hull.points, part.hull.triangles);
}

void Decomposition::finish(ConvexPiece& part) {
  part.corners.reserve(part.solid.points.size());
  pacer_.each(0, part.solid.points.size(), [&](std::size_t k) {
    part.corners.push_back(to_float(part.solid.points[k]));
    part.box.add(part.solid.points[k]);
  });
  make_hull(part);
  part.is_done = part.hull_volume <= limits_.excess * part.volume;
}

/// The cost of a cut, relative to the part's hull. HUGE_VAL if the part stays whole, a body has no hull, or it exceeds `most`.
double Decomposition::cost(const ConvexPiece& part, const NotchPlanes::Candidate& candidate, double most) {
  s_.cutter.cut(part.solid, candidate.plane, on_plane_, pacer_);
  const std::span<const PolyhedronCutter::Body> bodies = s_.cutter.bodies();
  if (bodies.size() < 2) return HUGE_VAL;
  const double others = kAreaCost * s_.cutter.cut_area() / part.hull_area - kVotesWorth * candidate.votes +
                        kBodyCost * static_cast<double>(bodies.size() - 2);
  double sum = 0, squares = 0;
  for (const PolyhedronCutter::Body& body : bodies) {
    const double volume = trial_volume(s_.cutter.corners(body));
    if (volume == 0) return HUGE_VAL;
    sum += std::max(volume, body.volume);
    const double left = std::max(0.0, volume - limits_.excess * body.volume);
    squares += left * left;
    if (others + sum / part.hull_volume > most) return HUGE_VAL;
  }
  return others + (sum + kLeftCost * std::sqrt(squares)) / part.hull_volume;
}

bool Decomposition::split(std::size_t k) {
  ConvexPiece& part = parts_[k];
  const CutPlane* best = nullptr;
  double least = HUGE_VAL;
  for (const NotchPlanes::Candidate& c : s_.notches.find(part.solid, part.hull, size_, kTried, execution_)) {
    const double here = cost(part, c, least);
    if (!(here < least)) continue;
    least = here;
    best = &c.plane;
  }
  if (!best) return false;
  s_.cutter.cut(part.solid, *best, on_plane_, pacer_);
  std::vector<ConvexPiece> made(s_.cutter.bodies().size());
  for (std::size_t b = 0; b < made.size(); ++b) {
    s_.cutter.write(s_.cutter.bodies()[b], made[b].solid, pacer_);
    made[b].volume = s_.cutter.bodies()[b].volume;
    finish(made[b]);
  }
  parts_[k] = std::move(made[0]);
  parts_.insert(parts_.end(), std::make_move_iterator(made.begin() + 1), std::make_move_iterator(made.end()));
  return true;
}

/// The part whose hull exceeds its volume most; parts_.size() if none is left to divide.
std::size_t Decomposition::worst() const {
  std::size_t worst = parts_.size();
  double most = 0;
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    const double more = parts_[k].hull_volume - parts_[k].volume;
    if (parts_[k].is_done || (worst != parts_.size() && more <= most)) continue;
    most = more;
    worst = k;
  }
  return worst;
}

double Decomposition::common_volume(const ConvexPiece& a, const ConvexPiece& b) {
  s_.points = a.hull.points;
  s_.points.insert(s_.points.end(), b.hull.points.begin(), b.hull.points.end());
  return volume_within(s_.points,
                       s_.builder.build(s_.points, kMaxHullPoints, execution_, {}, kHullTolerance));
}

bool Decomposition::touch(const ConvexPiece& a, const ConvexPiece& b) const {
  Box wide = a.box;
  const Vec3d reach{on_plane_, on_plane_, on_plane_};
  wide.add(a.box.min - reach);
  wide.add(a.box.max + reach);
  return wide.intersects(b.box);
}

bool Decomposition::may_merge(const ConvexPiece& a, const ConvexPiece& b, double common) const {
  return common - a.hull_volume - b.hull_volume <= kFreeMerge * common ||
         common <= (1 + kMergedExcess * (limits_.excess - 1)) * (a.volume + b.volume);
}

/// Merges the pair whose common hull grows least, until no pair may be merged and at most HullLimits::count parts are left.
/// While there are more, parts need not touch: two rungs in a line may share a hull across the post between them.
void Decomposition::merge() {
  constexpr double kUnknown = -1;
  std::vector<std::vector<double>> common(parts_.size(), std::vector<double>(parts_.size(), kUnknown));
  while (parts_.size() > 1) {
    const bool is_forced = parts_.size() > limits_.count;
    double least = HUGE_VAL;
    std::size_t first = 0, second = 0;
    for (std::size_t a = 0; a < parts_.size(); ++a)
      for (std::size_t b = a + 1; b < parts_.size(); ++b) {
        if (!is_forced && !touch(parts_[a], parts_[b])) continue;
        if (common[a][b] == kUnknown) common[a][b] = common_volume(parts_[a], parts_[b]);
        const double more = common[a][b] - parts_[a].hull_volume - parts_[b].hull_volume;
        if (more >= least || !(is_forced || may_merge(parts_[a], parts_[b], common[a][b]))) continue;
        least = more;
        first = a;
        second = b;
      }
    if (least == HUGE_VAL) break;
    ConvexPiece &to = parts_[first], &from = parts_[second];
    to.corners.insert(to.corners.end(), from.corners.begin(), from.corners.end());
    to.box.add(from.box);
    to.volume += from.volume;
    make_hull(to);
    const auto gone = static_cast<std::ptrdiff_t>(second);
    parts_.erase(parts_.begin() + gone);
    common.erase(common.begin() + gone);
    for (std::vector<double>& row : common) row.erase(row.begin() + gone);
    for (std::size_t k = 0; k < parts_.size(); ++k) common[first][k] = common[k][first] = kUnknown;
  }
}

ConvexParts Decomposition::run(std::span<const Vec3f> points, TriangleSpan triangles) {
  ConvexParts out;
  add_shells(points, triangles);
  ConvexPiece whole;
  whole.corners.assign(points.begin(), points.end());
  for (const Vec3f& p : points) whole.box.add(to_double(p));
  for (const ConvexPiece& p : parts_) whole.volume += p.volume;
  make_hull(whole);
  if (whole.hull_volume == 0) return out;
  size_ = whole.box.longest_side();
  on_plane_ = kOnPlane * size_;
  out.volume = whole.volume;
  if (limits_.count <= 1 || parts_.empty() || whole.hull_volume <= limits_.excess * whole.volume) {
    parts_.clear();
    parts_.push_back(std::move(whole));
  } else {
    for (ConvexPiece& p : parts_) finish(p);
    while (parts_.size() < kPartsPerHull * limits_.count) {
      const std::size_t k = worst();
      if (k == parts_.size()) break;
      if (!split(k)) parts_[k].is_done = true;
    }
    merge();
  }
  for (ConvexPiece& p : parts_) {
    out.simplified += p.is_simplified;
    out.excess += p.hull_volume;
    if (p.volume > 0) out.largest_excess = std::max(out.largest_excess, p.hull_volume / p.volume);
    out.hulls.push_back(std::move(p.hull));
  }
  out.excess = out.volume > 0 ? out.excess / out.volume : 0;
  return out;
}

}  // namespace

ConvexParts make_convex_parts(std::span<const Vec3f> points, TriangleSpan triangles, const HullLimits& limits,
                              const Execution& execution) {
  return Decomposition(limits, execution).run(points, triangles);
}

}  // namespace fracture
