#include "common/physics/notches.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/id.hpp"

namespace fracture {
namespace {

/// Sine of the angle below which an edge counts as flat: 0.06 degrees.
constexpr double kStraight = 1e-3;
/// Votes for planes are added if their normals are within 8 degrees (cosine), and one plane's notch is this near to the
/// other plane, relative to the size of the solid.
constexpr double kAlike = 0.99, kNear = 0.03;
/// Maximum number of different planes with votes.
constexpr std::size_t kMostPlanes = 40;

}  // namespace

void NotchPlanes::list_notches(const Polyhedron& solid, Pacer& pacer) {
  notches_.clear();
  open_.assign(solid.points.size(), kNoIndex);
  next_.resize(solid.edges.size());
  face_of_.resize(solid.edges.size());
  std::uint32_t e = 0;
  for (std::uint32_t f = 0; f < solid.faces.size(); ++f) {
    pacer.step(4);
    for (; e < solid.faces[f].end; ++e) {
      face_of_[e] = f;
      const auto [from, to] = solid.edges[e];
      std::uint32_t* twin = &open_[std::min(from, to)];
      while (*twin != kNoIndex && (solid.edges[*twin].from != to || solid.edges[*twin].to != from))
        twin = &next_[*twin];
      if (*twin == kNoIndex) {
        next_[e] = open_[std::min(from, to)];
        open_[std::min(from, to)] = e;
        continue;
      }
      const std::uint32_t other = face_of_[*twin];
      *twin = next_[*twin];
      const Vec3d &left = solid.faces[f].normal, &right = solid.faces[other].normal;
      const Vec3d d = solid.points[to] - solid.points[from];
      const double l = length(d);
      if (!(l > 0)) continue;
      if (!(dot(cross(left, right), d) < -kStraight * l)) continue;
      const Vec3d bend = left - right;
      notches_.push_back(
          {0.5 * (solid.points[from] + solid.points[to]), (1 / l) * d, left, right, l * length(bend), e});
    }
  }
}

void NotchPlanes::weigh(const CollisionHull& hull, Pacer& pacer) {
  walls_.clear();
  for (const auto& t : hull.triangles) {
    const Vec3d a = to_double(hull.points[t[0]]);
    const Vec3d n = cross(to_double(hull.points[t[1]]) - a, to_double(hull.points[t[2]]) - a);
    const double l = length(n);
    if (l > 0) walls_.push_back({(1 / l) * n, dot((1 / l) * n, a)});
  }
  for (Notch& notch : notches_) {
    pacer.step(1 + walls_.size() / 8);
    double depth = HUGE_VAL;
    for (const CutPlane& wall : walls_) depth = std::min(depth, wall.offset - dot(wall.normal, notch.middle));
    notch.weight *= std::max(depth, 0.0);
  }
}

void NotchPlanes::vote(const CutPlane& plane, const Notch& notch, double size) {
  for (Candidate& c : candidates_)
    if (std::fabs(dot(c.plane.normal, plane.normal)) >= kAlike &&
        std::fabs(dot(c.plane.normal, notch.middle) - c.plane.offset) <= kNear * size) {
      c.votes += notch.weight;
      return;
    }
  if (candidates_.size() < kMostPlanes) candidates_.push_back({plane, notch.weight});
}

std::span<const NotchPlanes::Candidate> NotchPlanes::find(const Polyhedron& solid, const CollisionHull& hull,
                                                          double size, std::size_t most,
                                                          const Execution& execution) {
  Pacer pacer(execution);
  list_notches(solid, pacer);
  weigh(hull, pacer);
  sort_with_polls(execution, notches_.begin(), notches_.end(), [](const Notch& a, const Notch& b) {
    return a.weight != b.weight ? a.weight > b.weight : a.edge < b.edge;
  });
  candidates_.clear();
  double sum = 0;
  for (const Notch& notch : notches_) {
    pacer.step(kMostPlanes);
    if (!(notch.weight > 0)) break;
    sum += notch.weight;
    const auto vote_for = [&](const Vec3d& normal) {
      const double l = length(normal);
      if (l > kStraight) vote({(1 / l) * normal, dot((1 / l) * normal, notch.middle)}, notch, size);
    };
    vote_for(notch.left);
    vote_for(notch.right);
    vote_for(cross(notch.along, notch.left + notch.right));
  }
  std::stable_sort(candidates_.begin(), candidates_.end(),
                   [](const Candidate& a, const Candidate& b) { return a.votes > b.votes; });
  if (candidates_.size() > most) candidates_.resize(most);
  for (Candidate& c : candidates_) c.votes /= sum;
  return candidates_;
}

}  // namespace fracture
