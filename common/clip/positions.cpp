#include "common/clip/positions.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "common/exact/approx.hpp"
#include "common/exact/number_types.hpp"

namespace fracture {
namespace {

using exact::Approx;
using exact::BigInt;
using exact::BinaryScale;
using exact::Point;

/// A point as origin + numerator / denominator, over any number type.
template <class T>
struct Fraction {
  Point<T> numerator;
  T denominator;
};

// The three constructions; derivations stand in exact/side.cpp. Each takes its input points in the order
// listed.
struct EdgeCutFormula {        // mesh edge (a, b) x bisector(i, k): a + e (c_k - 2 u·(a - i)) / (2 u·e)
  std::array<Vec3d, 4> input;  // a, b, i, k
  template <class T>
  Fraction<T> operator()(const std::array<Point<T>, 4>& p) const {
    const Point<T> e = p[1] - p[0], u = p[3] - p[2];
    const T ua = dot(u, p[0] - p[2]), ue = dot(u, e);
    const T t = dot(u, u) - (ua + ua);
    return {{e.x * t, e.y * t, e.z * t}, ue + ue};
  }
};
struct TriangleCutFormula {    // mesh triangle (a, b, c) x Voronoi edge (i, k, l), from origin i
  std::array<Vec3d, 6> input;  // i, k, l, a, b, c
  template <class T>
  Fraction<T> operator()(const std::array<Point<T>, 6>& p) const {
    const Point<T> uk = p[1] - p[0], ul = p[2] - p[0], n = cross(p[4] - p[3], p[5] - p[3]);
    const Point<T> d = cross(uk, ul), f = cross(ul, n), g = cross(n, uk);
    const T na = dot(n, p[3] - p[0]), ck = dot(uk, uk), cl = dot(ul, ul), na2 = na + na, delta = dot(n, d);
    return {
        {na2 * d.x + ck * f.x + cl * g.x, na2 * d.y + ck * f.y + cl * g.y, na2 * d.z + ck * f.z + cl * g.z},
        delta + delta};
  }
};
struct CircumcenterFormula {  // Voronoi vertex (i, j, k, l), from origin i
  std::array<Vec3d, 4> input;
  template <class T>
  Fraction<T> operator()(const std::array<Point<T>, 4>& p) const {
    const Point<T> uj = p[1] - p[0], uk = p[2] - p[0], ul = p[3] - p[0];
    const Point<T> f = cross(uk, ul), g = cross(ul, uj), h = cross(uj, uk);
    const T cj = dot(uj, uj), ck = dot(uk, uk), cl = dot(ul, ul), delta = dot(uj, f);
    return {{cj * f.x + ck * g.x + cl * h.x, cj * f.y + ck * g.y + cl * h.y, cj * f.z + ck * g.z + cl * h.z},
            delta + delta};
  }
};

struct Placed {
  Vec3d point;
  std::array<std::int32_t, 3> steps;
};

/// numerator / denominator, rounded to nearest, ties to even; denominator > 0.
BigInt round_quotient(const BigInt& numerator, const BigInt& denominator) {
  BigInt quotient, remainder;
  boost::multiprecision::divide_qr(numerator, denominator, quotient, remainder);
  if (remainder.sign() < 0) {  // floor
    remainder += denominator;
    --quotient;
  }
  const BigInt twice = remainder << 1;
  if (twice > denominator ||
      (twice == denominator && boost::multiprecision::bit_test(BigInt(abs(quotient)), 0)))
    ++quotient;
  return quotient;
}

/// numerator / denominator * 2^exponent as a double (64 quotient bits before the one rounding that shows).
double quotient_to_double(const BigInt& numerator, const BigInt& denominator, int exponent) {
  if (numerator.is_zero()) return 0;
  const auto bits = [](const BigInt& v) {
    return static_cast<int>(boost::multiprecision::msb(BigInt(abs(v))));
  };
  const int shift = 64 - (bits(numerator) - bits(denominator));
  const BigInt scaled = shift >= 0 ? BigInt(numerator << shift) : numerator;
  const BigInt below = shift >= 0 ? denominator : BigInt(denominator << -shift);
  return std::ldexp(static_cast<double>(BigInt(scaled / below)), exponent - shift);
}

template <class Formula>
Placed place_exactly(const Formula& formula, const SeamLattice& lattice) {
  BinaryScale scale;
  for (const Vec3d& p : formula.input) scale.include(p);
  std::array<Point<BigInt>, std::tuple_size_v<decltype(formula.input)>> p;
  for (std::size_t k = 0; k < p.size(); ++k) p[k] = scale.scaled<BigInt>(formula.input[k]);
  Fraction<BigInt> f = formula(p);
  if (f.denominator.sign() < 0) f = {{-f.numerator.x, -f.numerator.y, -f.numerator.z}, -f.denominator};
  const std::array<BigInt, 3> offset{f.numerator.x, f.numerator.y, f.numerator.z};
  const std::array<BigInt, 3> origin{p[0].x, p[0].y, p[0].z};
  Placed placed;
  for (int a = 0; a < 3; ++a) {
    const BigInt numerator = origin[a] * f.denominator + offset[a];
    placed.point[a] = quotient_to_double(numerator, f.denominator, scale.lowest_bit);
    // In units of the lattice: times 2^(lowest_bit - exponent).
    const int shift = scale.lowest_bit - lattice.exponent[a];
    const BigInt rounded = shift >= 0 ? round_quotient(numerator << shift, f.denominator)
                                      : round_quotient(numerator, f.denominator << -shift);
    placed.steps[a] = static_cast<std::int32_t>(rounded);
  }
  return placed;
}

template <class Formula>
Placed place(const Formula& formula, const SeamLattice& lattice, const Vec3d& step,
             std::atomic<std::uint64_t>& exact) {
  std::array<Point<Approx>, std::tuple_size_v<decltype(formula.input)>> p;
  for (std::size_t k = 0; k < p.size(); ++k) {
    const Vec3d& q = formula.input[k];
    p[k] = {Approx(q.x), Approx(q.y), Approx(q.z)};
  }
  const Fraction<Approx> f = formula(p);
  const double den = f.denominator.value, den_error = 1.001 * f.denominator.error;
  Placed placed;
  bool certain = std::fabs(den) > 2 * den_error;
  const std::array<Approx, 3> offset{f.numerator.x, f.numerator.y, f.numerator.z};
  for (int a = 0; a < 3 && certain; ++a) {
    const double q = offset[a].value / den;
    const double x = formula.input[0][a] + q;
    const double error = 1.001 * (offset[a].error + std::fabs(q) * den_error) / (std::fabs(den) - den_error) +
                         0x1.0p-52 * (std::fabs(q) + std::fabs(x));
    // A double that is good to a thousandth of a step serves for figures; a rounding that the error cannot
    // change is the exact one.
    const double y = x / step[a], k = std::nearbyint(y);
    certain = error <= 0.001 * step[a] && std::fabs(y - k) + error / step[a] < 0.4999999;
    placed.point[a] = x;
    if (certain) placed.steps[a] = static_cast<std::int32_t>(k);
  }
  if (certain) return placed;
  exact.fetch_add(1, std::memory_order_relaxed);
  return place_exactly(formula, lattice);
}

/// The edge cut with a static error bound: by far the most frequent construction. False when the bound does
/// not decide.
bool place_edge_cut(const EdgeCutFormula& formula, const Vec3d& step, Placed& placed) {
  const auto& [a, b, i, k] = formula.input;
  const Vec3d u = k - i, w = a - i, e = b - a;
  const auto absolute = [](const Vec3d& x, const Vec3d& y) {
    return std::fabs(x.x * y.x) + std::fabs(x.y * y.y) + std::fabs(x.z * y.z);
  };
  // t = (u·u - 2 u·w) / (2 u·e): differences and products are off by 2^-53 relative, fewer than 8 roundings a
  // term.
  const double numerator = dot(u, u) - 2 * dot(u, w), denominator = 2 * dot(u, e);
  const double numerator_error = 0x1.0p-49 * (dot(u, u) + 2 * absolute(u, w));
  const double denominator_error = 0x1.0p-49 * 2 * absolute(u, e);
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
    int e = -100;  // a flat axis: any step will do
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

VertexPositions place_vertices(const Solid& solid, const VoronoiDiagram& diagram, const SurfaceCuts& cuts,
                               const Winding& winding, const Execution& execution) {
  VertexPositions out;
  out.lattice = SeamLattice(solid.box);
  out.first_constructed = cuts.first_b();
  const std::size_t b = cuts.edge_cuts.size(), c = cuts.triangle_cuts.size(),
                    d = winding.inner_vertices.size();
  out.points.resize(b + c + d);
  out.steps.resize(b + c + d);
  const Vec3d step = out.lattice.step();
  std::atomic<std::uint64_t> exact{0};
  const auto mesh_vertex = [&](std::uint32_t v) { return to_double(solid.positions[v]); };

  parallel_for(execution, out.points.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      Placed placed;
      if (n < b) {
        const EdgeCut& cut = cuts.edge_cuts[n];
        const auto [lo, hi] = solid.edge_vertices[cut.edge];
        const EdgeCutFormula formula{
            {mesh_vertex(lo), mesh_vertex(hi), diagram.site(cut.from), diagram.site(cut.to)}};
        if (!place_edge_cut(formula, step, placed)) placed = place(formula, out.lattice, step, exact);
      } else if (n < b + c) {
        const TriangleCut& cut = cuts.triangle_cuts[n - b];
        const auto& v = solid.triangles[cut.triangle];
        placed = place(TriangleCutFormula{{diagram.site(cut.sites[0]), diagram.site(cut.sites[1]),
                                           diagram.site(cut.sites[2]), mesh_vertex(v[0]), mesh_vertex(v[1]),
                                           mesh_vertex(v[2])}},
                       out.lattice, step, exact);
      } else {
        // In ascending order of the sites, so that the doubles do not depend on how the tetrahedron was made.
        std::array<SiteId, 4> v = diagram.dual().tets[winding.inner_vertices[n - b - c].tet].v;
        std::sort(v.begin(), v.end());
        placed = place(CircumcenterFormula{{diagram.site(v[0]), diagram.site(v[1]), diagram.site(v[2]),
                                            diagram.site(v[3])}},
                       out.lattice, step, exact);
      }
      out.points[n] = placed.point;
      out.steps[n] = placed.steps;
    }
  });
  out.exact_roundings = exact.load();
  return out;
}

}  // namespace fracture
