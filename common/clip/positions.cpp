#include "common/clip/positions.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/pacer.hpp"
#include "common/clip/construction.hpp"
#include "common/clip/cut_formulas.hpp"
#include "common/clip/image_constructions.hpp"

namespace fracture {
namespace {

using namespace clip_detail;

/// Places an edge cut with a static error bound. This is by far the most frequent construction. Returns false
/// if the bound does not decide the rounding.
bool place_edge_cut(const EdgeCutFormula& formula, const Vec3d& step, Placed& placed) {
  const auto& [a, b, i, k] = formula.input;
  const Vec3d u = k - i, w = a - i, e = b - a;
  const auto absolute = [](const Vec3d& x, const Vec3d& y) {
    return std::fabs(x.x * y.x) + std::fabs(x.y * y.y) + std::fabs(x.z * y.z);
  };
  // t = (u·u - 2 u·w) / (2 u·e): differences and products have a relative error of 2^-53, with fewer than 8
  // roundings per term. Underflow loses at most 2^-1075 in each of fewer than 16 products, including those of
  // the bounds. kTiny exceeds this.
  constexpr double kTiny = 0x1p-1000;
  const double numerator = dot(u, u) - 2 * dot(u, w), denominator = 2 * dot(u, e);
  const double numerator_error = 0x1.0p-49 * (dot(u, u) + 2 * absolute(u, w)) + kTiny;
  const double denominator_error = 0x1.0p-49 * 2 * absolute(u, e) + kTiny;
  if (!(std::fabs(denominator) > 2 * denominator_error)) return false;
  const double t = numerator / denominator;
  const double t_error = 1.001 * (numerator_error + std::fabs(t) * denominator_error) /
                             (std::fabs(denominator) - denominator_error) +
                         0x1.0p-52 * std::fabs(t);
  for (int axis = 0; axis < 3; ++axis) {
    const double q = e[axis] * t, x = a[axis] + q;
    const double error = 1.001 * std::fabs(e[axis]) * t_error + 0x1.0p-51 * (std::fabs(q) + std::fabs(x));
    const double y = x / step[axis], rounded = std::nearbyint(y);
    if (!(error <= 0.001 * step[axis] && std::fabs(y - rounded) + error / step[axis] < 0.4999999))
      return false;
    placed.point[axis] = x;
    placed.steps[static_cast<std::size_t>(axis)] = static_cast<std::int32_t>(rounded);
  }
  return true;
}

}  // namespace

SeamLattice::SeamLattice(const Box& box) {
  for (int a = 0; a < 3; ++a) {
    const double reach = std::fmax(std::fabs(box.min[a]), std::fabs(box.max[a]));
    const double m = std::fmax(reach, box.max[a] - box.min[a]);
    int e = -100;  // for a flat axis, any step is suitable
    if (m > 0) {
      const double mantissa =
          std::frexp(m, &e);  // m = mantissa * 2^e, ceil(log2 m) = e, or e - 1 for a power of two
      if (mantissa == 0.5) --e;
    }
    exponent[a] = e - 23;
  }
}

Vec3d SeamLattice::step() const {
  return {std::ldexp(1.0, exponent[0]), std::ldexp(1.0, exponent[1]), std::ldexp(1.0, exponent[2])};
}

Vec3d SeamLattice::to_world(const std::array<std::int32_t, 3>& steps) const {
  return {std::ldexp(steps[0], exponent[0]), std::ldexp(steps[1], exponent[1]),
          std::ldexp(steps[2], exponent[2])};
}

VertexPositions place_vertices(const Solid& solid, const Solid& image, const VoronoiDiagram& diagram,
                               const SurfaceCuts& cuts, const Winding& winding, const Execution& execution) {
  VertexPositions out;
  out.lattice = SeamLattice(solid.box);
  out.first_constructed = cuts.first_b();
  const std::size_t b = cuts.edge_cuts.size(), c = cuts.triangle_cuts.size(),
                    d = winding.inner_vertices.size();
  resize_with_polls(execution, out.points, b + c + d);
  resize_with_polls(execution, out.steps, b + c + d);
  const Vec3d step = out.lattice.step();
  const auto at = [&](VertexId v) { return to_double(solid.positions[v]); };
  const auto image_at = [&](VertexId v) { return to_double(image.positions[v]); };
  const auto site = [&](SiteId s) { return diagram.site(s); };
  const auto placed_by = [&](const auto& formula) { return place(formula, out.lattice, step); };
  const CellMap& map = diagram.map();

  const auto place_edge = [&](const EdgeCut& cut) {
    const auto [lo, hi] = solid.edge_vertices[cut.edge];
    if (map)
      return placed_by(
          ImageEdgeCutFormula{{at(lo), at(hi), image_at(lo), image_at(hi), site(cut.from), site(cut.to)}});
    const EdgeCutFormula formula{{at(lo), at(hi), site(cut.from), site(cut.to)}};
    Placed placed;
    return place_edge_cut(formula, step, placed) ? placed : placed_by(formula);
  };
  const auto place_triangle = [&](const TriangleCut& cut) {
    const auto& v = solid.triangles[cut.triangle];
    const Vec3d i = site(cut.sites[0]), k = site(cut.sites[1]), l = site(cut.sites[2]);
    if (map)
      return placed_by(ImageTriangleCutFormula{
          {at(v[0]), at(v[1]), at(v[2]), image_at(v[0]), image_at(v[1]), image_at(v[2]), i, k, l}});
    return placed_by(TriangleCutFormula{{i, k, l, at(v[0]), at(v[1]), at(v[2])}});
  };
  const auto place_inner = [&](const InnerVertex& inner) {
    // In ascending order of the sites, so that the doubles do not depend on how the tetrahedron was built.
    std::array<SiteId, 4> v = diagram.dual().tets[inner.tet].v;
    std::sort(v.begin(), v.end());
    if (map) {
      // All four sites are in the place of one frame. Its shift can be subtracted exactly.
      const CellMap::Frame& frame = map.at(site(v[0]));
      const auto unshifted = [&](SiteId s) { return site(s) - frame.shift; };
      const auto& rows = frame.matrix.rows;
      return placed_by(ImageCircumcenterFormula{
          {unshifted(v[0]), unshifted(v[1]), unshifted(v[2]), unshifted(v[3]), rows[0], rows[1], rows[2]}});
    }
    return placed_by(CircumcenterFormula{{site(v[0]), site(v[1]), site(v[2]), site(v[3])}});
  };

  parallel_for(execution, out.points.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      const Placed placed = n < b       ? place_edge(cuts.edge_cuts[n])
                            : n < b + c ? place_triangle(cuts.triangle_cuts[n - b])
                                        : place_inner(winding.inner_vertices[n - b - c]);
      out.points[n] = placed.point;
      out.steps[n] = placed.steps;
    }
  });
  return out;
}

}  // namespace fracture
