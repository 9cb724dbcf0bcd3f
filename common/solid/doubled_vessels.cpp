#include "common/solid/doubled_vessels.hpp"

#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/base/words.hpp"
#include "common/solid/faults.hpp"
#include "common/solid/holes.hpp"
#include "common/solid/mirrors.hpp"
#include "common/solid/nonmanifold.hpp"
#include "common/solid/orientation.hpp"
#include "common/solid/polled.hpp"
#include "common/solid/shells.hpp"

namespace fracture::solid_detail {
namespace {

/// The triangles that may have a copy for the other side. If a piece has more than one triangle on each side, each of them
/// has an edge with four uses.
std::vector<TriangleId> with_crowded_edges(const Surface& surface, const EdgeTable& edges,
                                           const Execution& execution) {
  std::vector<std::uint8_t> crowded;
  edges.for_each(execution, [&](VertexId, VertexId, std::span<const EdgeUse> uses) {
    if (uses.size() < 4) return;
    if (crowded.empty()) crowded = filled<std::uint8_t>(execution, surface.triangles.size(), 0);
    for (const EdgeUse& use : uses) crowded[use.half_edge() / 3] = 1;
  });
  std::vector<TriangleId> found;
  for_each_polled(execution, crowded.size(), [&](std::size_t t) {
    if (crowded[t]) found.push_back(TriangleId{t});
  });
  return found;
}

/// The triangles by the pieces that they belong to: the lowest triangle of each piece.
std::vector<std::uint32_t> find_pieces(const Surface& surface, const EdgeTable& edges,
                                       const Execution& execution) {
  DisjointSets sets = singletons(execution, surface.triangles.size());
  edges.for_each(execution, [&](VertexId, VertexId, std::span<const EdgeUse> uses) {
    for (const EdgeUse& use : uses.subspan(1)) sets.unite(uses[0].half_edge() / 3, use.half_edge() / 3);
  });
  std::vector<std::uint32_t> pieces = filled(execution, surface.triangles.size(), kNoIndex);
  for_each_polled(execution, pieces.size(),
                  [&](std::size_t t) { pieces[t] = sets.find(static_cast<std::uint32_t>(t)); });
  return pieces;
}

/// One side of each piece of which nearly all triangles are doubled. The source of its triangles are triangles of the
/// surface: of two copies, the lower one.
Surface one_side(const Surface& surface, const std::vector<std::uint32_t>& pieces,
                 const std::vector<TriangleId>& mirror, const Execution& execution) {
  const std::size_t count = surface.triangles.size();
  std::vector<double> area = filled(execution, count, 0.0), doubled = filled(execution, count, 0.0);
  for_each_polled(execution, count, [&](std::size_t t) {
    const double own = area_of(surface, t);
    area[pieces[t]] += own;
    if (mirror[t] != kNoTriangle) doubled[pieces[t]] += own;
  });
  Surface side;
  std::vector<VertexId> vertex_of = filled(execution, surface.positions.size(), kNoVertex);
  for_each_polled(execution, count, [&](std::size_t t) {
    const std::uint32_t piece = pieces[t];
    if (!(doubled[piece] > 0 && doubled[piece] >= kNearlyAll * area[piece])) return;
    if (mirror[t] != kNoTriangle && mirror[t] < TriangleId{t}) return;
    Triangle corners = surface.triangles[t];
    for (VertexId& v : corners) {
      if (vertex_of[v] == kNoVertex) {
        vertex_of[v] = VertexId{side.positions.size()};
        side.positions.push_back(surface.positions[v]);
      }
      v = vertex_of[v];
    }
    side.triangles.push_back(corners);
    side.source.push_back(static_cast<std::uint32_t>(t));
  });
  return side;
}

/// Closes the surface in the way of make_solid().
Shells close(Surface& side, double tolerance, const Execution& execution) {
  EdgeTable edges(side, execution);
  SolidReport ignored;
  if (orient_patches(side, edges, ignored, execution)) edges = EdgeTable(side, execution);
  pair_clean_edges(side, edges, execution);
  pair_nonmanifold_edges(side, edges, execution);
  fill_holes(side, tolerance, execution);
  split_umbrellas(side, execution);
  return find_shells(side, execution);
}

/// The result of closing one side of a piece.
struct ClosedPiece {
  double own = 0, fill = 0;  ///< m²
  double enclosed = 0;       ///< m³
  /// m³, signed, of the piece with both sides. Two copies cancel out, so only the other triangles count.
  double before = 0;
  bool is_body = false;

  bool is_vessel() const {
    return is_body && fill <= kMostOpening * own && std::fabs(before) <= kMostBefore * enclosed;
  }
};

}  // namespace

bool drop_inner_sides(Surface& surface, const EdgeTable& edges, double tolerance, SolidReport& report,
                      const Execution& execution) {
  const std::vector<TriangleId> candidates = with_crowded_edges(surface, edges, execution);
  if (candidates.empty()) return false;
  const std::vector<TriangleId> mirror = find_mirrors(surface, candidates, execution);
  const std::vector<std::uint32_t> pieces = find_pieces(surface, edges, execution);
  Surface side = one_side(surface, pieces, mirror, execution);
  if (side.triangles.empty()) return false;
  const Shells shells = close(side, tolerance, execution);

  // A shell's first triangle is not a fill, because fills come after all other triangles.
  const auto piece_of = [&](std::size_t t) {
    return pieces[side.source[shells.list[shells.of_triangle[t]].first]];
  };
  std::vector<ClosedPiece> closed = filled(execution, surface.triangles.size(), ClosedPiece{});
  for_each_polled(execution, side.triangles.size(), [&](std::size_t t) {
    ClosedPiece& piece = closed[piece_of(t)];
    (side.source[t] == kNoIndex ? piece.fill : piece.own) += area_of(side, t);
    piece.is_body |= !shells.list[shells.of_triangle[t]].flat;
    if (const std::uint32_t source = side.source[t]; source != kNoIndex && mirror[source] == kNoTriangle) {
      const Triangle& c = surface.triangles[source];
      const Vec3d origin = to_double(surface.positions[surface.triangles[pieces[source]][0]]);
      const auto corner = [&](std::size_t k) { return to_double(surface.positions[c[k]]) - origin; };
      piece.before += dot(corner(0), cross(corner(1), corner(2))) / 6;
    }
  });
  for (const Shell& shell : shells.list)
    closed[pieces[side.source[shell.first]]].enclosed += std::fabs(shell.volume);

  std::vector<std::uint8_t> doomed = filled<std::uint8_t>(execution, surface.triangles.size(), 0);
  std::uint64_t vessels = 0, dropped = 0;
  std::optional<TriangleId> first;
  for_each_polled(execution, side.triangles.size(), [&](std::size_t t) {
    const std::uint32_t source = side.source[t];
    if (source == kNoIndex) return;
    const ClosedPiece& piece = closed[pieces[source]];
    if (!piece.is_vessel()) return;
    if (source == pieces[source]) ++vessels;
    if (mirror[source] == kNoTriangle) return;
    const bool turned = !side.flipped.empty() && side.flipped[t] != 0,
               inward = shells.list[shells.of_triangle[t]].volume < 0;
    const TriangleId inner = turned != inward ? TriangleId{source} : mirror[source];
    doomed[inner] = 1;
    ++dropped;
    if (!first || inner < *first) first = inner;
  });
  if (dropped == 0) return false;
  const Vec3f& sample = surface.positions[surface.triangles[*first][0]];
  report.add_sample("duplicates_dropped", sample);
  report.duplicates_dropped += dropped;
  report.remarks.note(
      counted(vessels, "open piece has", "open pieces have") +
      " every triangle twice, once for each side, and " + (vessels == 1 ? "is a vessel" : "are vessels") +
      ". Only the outer sides were kept: " +
      counted(dropped, "triangle of the inner sides was", "triangles of the inner sides were") +
      " left out, the first at " + place(sample) + ". Use 'thickness' to make walls instead.");
  surface.remove(doomed, execution);
  return true;
}

}  // namespace fracture::solid_detail
