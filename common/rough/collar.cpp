#include "common/rough/collar.hpp"

#include "common/clip/delaunay_flips.hpp"

namespace fracture {
namespace {

std::int64_t square_distance(const LatticePoint& a, const LatticePoint& b) {
  return (b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y);
}

}  // namespace

/// points[0 .. rim_begin) are counter-clockwise, and the others are clockwise and inside them. Returns false
/// if no next triangle would be counter-clockwise.
bool Collar::zip(std::span<const LatticePoint> points, std::uint32_t rim_begin) {
  const std::uint32_t outer = rim_begin, inner = static_cast<std::uint32_t>(points.size()) - rim_begin;
  std::uint32_t start = rim_begin;  // first corner of the rim
  for (std::uint32_t k = rim_begin; k < points.size(); ++k)
    if (square_distance(points[k], points[0]) < square_distance(points[start], points[0])) start = k;
  // Corner i of the loop, and corner j of the rim counted from `start`, both counter-clockwise.
  const auto loop = [&](std::uint32_t i) { return i == outer ? 0 : i; };
  const auto rim = [&](std::uint32_t j) { return rim_begin + (start - rim_begin + inner - j) % inner; };
  std::uint32_t i = 0, j = 0;
  while (i < outer || j < inner) {
    const std::uint32_t a = loop(i), b = i < outer ? loop(i + 1) : a;
    const std::uint32_t c = rim(j), d = j < inner ? rim(j + 1) : c;
    const bool on_loop = i < outer && orient2d(points[a], points[b], points[c]) > 0;
    const bool on_rim = j < inner && orient2d(points[a], points[d], points[c]) > 0;
    if (!on_loop && !on_rim) return false;
    if (on_loop && !(on_rim && in_circle(points[a], points[b], points[c], points[d]))) {
      triangulation_.triangles.push_back({a, b, c});
      ++i;
    } else {
      triangulation_.triangles.push_back({a, d, c});
      ++j;
    }
  }
  return true;
}

bool Collar::build(std::span<const LatticePoint> points, std::span<const std::uint32_t> loop_begin,
                   std::size_t caps_loops, const Execution& execution) {
  triangulation_.clear();
  zipped_ = caps_loops == 1 && loop_begin.size() == 3 && zip(points, loop_begin[1]);
  if (zipped_) {
    triangulation_.regions = 1;
  } else {
    triangulation_.clear();
    triangulate(points, loop_begin, triangulation_, execution);
    if (triangulation_.unnested_loops > 0) return false;
  }
  flip_to_delaunay(points, triangulation_.triangles, execution);
  return true;
}

}  // namespace fracture
