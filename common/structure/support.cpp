#include "common/structure/support.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "common/base/pacer.hpp"
#include "common/structure/bond_graph.hpp"

namespace fracture {
namespace {

constexpr double kPi = 3.141592653589793;
/// Shear modulus divided by Young's modulus, for a Poisson's ratio of 1/4 (rock, concrete, glass: 0.2 to
/// 0.25).
constexpr double kShearModulus = 0.4;
constexpr double kTolerance = 1e-9;
/// Maximum number of bonds visited in all iterations together, which limits the time to about 2 s.
constexpr double kMaxVisits = 2e8;

struct Six {  ///< displacement and rotation, or force and moment
  Vec3d linear, angular;
};
Six operator+(const Six& a, const Six& b) { return {a.linear + b.linear, a.angular + b.angular}; }
Six operator*(double s, const Six& a) { return {s * a.linear, s * a.angular}; }
double dot(const Six& a, const Six& b) {
  return fracture::dot(a.linear, b.linear) + fracture::dot(a.angular, b.angular);
}

/// A bond as a beam between two rigid fragments. Lengths are divided by the size of the whole.
struct Beam {
  std::uint32_t a, b, bond;
  Vec3d arm_a, arm_b, normal;            ///< from the centres of mass to the cap's centroid
  double along, across, bending, twist;  ///< stiffnesses over Young's modulus

  Six stretch(const Six& xa, const Six& xb) const {
    return {xb.linear + cross(xb.angular, arm_b) - xa.linear - cross(xa.angular, arm_a),
            xb.angular - xa.angular};
  }
  /// Force and moment with which the beam pulls a (and b with the opposite), at the centroid.
  Six pull(const Six& stretched) const {
    const double n = fracture::dot(stretched.linear, normal), m = fracture::dot(stretched.angular, normal);
    return {across * stretched.linear + ((along - across) * n) * normal,
            bending * stretched.angular + ((twist - bending) * m) * normal};
  }
};

using Block = std::array<std::array<double, 6>, 6>;

/// Replaces a positive definite block by its Cholesky factor (lower triangle).
void factorize(Block& m) {
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = m[i][j];
      for (std::size_t k = 0; k < j; ++k) sum -= m[i][k] * m[j][k];
      m[i][j] = i == j ? std::sqrt(std::max(sum, 1e-300)) : sum / m[j][j];
    }
}

Six solve(const Block& l, const Six& r) {
  std::array<double, 6> x{r.linear.x, r.linear.y, r.linear.z, r.angular.x, r.angular.y, r.angular.z};
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t k = 0; k < i; ++k) x[i] -= l[i][k] * x[k];
    x[i] /= l[i][i];
  }
  for (std::size_t i = 6; i-- > 0;) {
    for (std::size_t k = i + 1; k < 6; ++k) x[i] -= l[k][i] * x[k];
    x[i] /= l[i][i];
  }
  return {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}};
}

/// The elastic network of the fragments that stand.
class Network {
 public:
  /// Throws Interrupted, as does solve_for().
  Network(std::size_t nodes, const std::vector<Beam>& beams, const std::vector<char>& fixed, Pacer& pacer)
      : beams_(beams), fixed_(fixed), inverse_(nodes), pacer_(pacer) {
    for (Block& b : inverse_)
      for (auto& row : b) row.fill(0);
    for (const Beam& beam : beams_) {
      pacer_.step(32);
      for (const bool first : {true, false}) {
        Block& block = inverse_[first ? beam.a : beam.b];
        for (std::size_t k = 0; k < 6; ++k) {  // the response to each unit displacement
          Six unit{};
          (k < 3 ? unit.linear : unit.angular)[static_cast<int>(k % 3)] = 1;
          const Six f = first ? at_a(beam, beam.pull(beam.stretch(unit, {})))
                              : at_b(beam, beam.pull(beam.stretch({}, unit)));
          const double column[6] = {-f.linear.x,  -f.linear.y,  -f.linear.z,
                                    -f.angular.x, -f.angular.y, -f.angular.z};
          for (std::size_t i = 0; i < 6; ++i) block[i][k] += column[i];
        }
      }
    }
    for (Block& b : inverse_) {
      pacer_.step(4);
      factorize(b);
    }
  }

  /// Solves the balance between the loads and the beams' pulls. Returns the residual relative to the loads.
  double solve_for(const std::vector<Six>& load, std::vector<Six>& x) const {
    const std::size_t n = load.size();
    x.assign(n, {});
    std::vector<Six> r = load, z(n), p(n), q(n);
    const auto precondition = [&] {
      for (std::size_t i = 0; i < n; ++i) {
        pacer_.step(4);  // includes the sums and steps below
        z[i] = fixed_[i] ? Six{} : solve(inverse_[i], r[i]);
      }
    };
    for (std::size_t i = 0; i < n; ++i)
      if (fixed_[i]) r[i] = {};
    const auto norm2 = [&](const std::vector<Six>& v) {
      double sum = 0;
      for (const Six& s : v) sum += dot(s, s);
      return sum;
    };
    const double scale = norm2(r);
    if (!(scale > 0)) return 0;
    precondition();
    p = z;
    double rz = inner(r, z), residual = scale;
    const auto visits = static_cast<double>(beams_.size() + n);
    const auto most = static_cast<std::size_t>(
        std::min(20.0 * static_cast<double>(n) + 200, std::max(100.0, kMaxVisits / visits)));
    for (std::size_t k = 0; k < most && residual > kTolerance * kTolerance * scale; ++k) {
      apply(p, q);
      const double pq = inner(p, q);
      if (!(pq > 0)) break;
      const double alpha = rz / pq;
      for (std::size_t i = 0; i < n; ++i) {
        x[i] = x[i] + alpha * p[i];
        r[i] = r[i] + (-alpha) * q[i];
      }
      precondition();
      const double next = inner(r, z);
      for (std::size_t i = 0; i < n; ++i) p[i] = z[i] + (next / rz) * p[i];
      rz = next;
      residual = norm2(r);
    }
    return std::sqrt(residual / scale);
  }

 private:
  /// Converts a force and moment at the centroid to a's (b's) centre of mass.
  static Six at_a(const Beam& beam, const Six& pull) {
    return {pull.linear, pull.angular + cross(beam.arm_a, pull.linear)};
  }
  static Six at_b(const Beam& beam, const Six& pull) {
    return {-1.0 * pull.linear, -1.0 * (pull.angular + cross(beam.arm_b, pull.linear))};
  }
  static double inner(const std::vector<Six>& a, const std::vector<Six>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += dot(a[i], b[i]);
    return sum;
  }
  /// Multiplies x by the stiffness; fixed fragments do not move.
  void apply(const std::vector<Six>& x, std::vector<Six>& out) const {
    std::fill(out.begin(), out.end(), Six{});
    for (const Beam& beam : beams_) {
      pacer_.step(2);
      const Six pull = beam.pull(beam.stretch(x[beam.a], x[beam.b]));
      out[beam.a] = out[beam.a] + -1.0 * at_a(beam, pull);
      out[beam.b] = out[beam.b] + -1.0 * at_b(beam, pull);
    }
    for (std::size_t i = 0; i < out.size(); ++i)
      if (fixed_[i]) out[i] = {};
  }

  const std::vector<Beam>& beams_;
  const std::vector<char>& fixed_;
  std::vector<Block> inverse_;  ///< Cholesky factors of the diagonal blocks
  Pacer& pacer_;
};

BondLoad load_of(const Beam& beam, const Six& pull, double area, double size) {
  BondLoad load;
  load.tension = fracture::dot(pull.linear, beam.normal);
  load.shear = length(pull.linear - load.tension * beam.normal);
  const double twist = fracture::dot(pull.angular, beam.normal);
  load.torsion = std::fabs(twist) * size;
  load.bending = length(pull.angular - twist * beam.normal) * size;
  // A disc of radius r = sqrt(A/π): bending adds M r / (A²/4π) at its rim, torsion T r / (A²/2π).
  const double rim = 2 * std::sqrt(kPi) / (area * std::sqrt(area));
  const double sigma = load.tension / area + 2 * rim * load.bending;
  const double tau = load.shear / area + rim * load.torsion;
  load.stress = std::max(0.0, sigma / 2 + std::sqrt(sigma * sigma / 4 + tau * tau));
  return load;
}

}  // namespace

Support analyze_support(const FragmentSet& set, const AnchoredFragments& anchored,
                        const SupportOptions& options, const Execution& execution) {
  const std::size_t n = set.fragments.size();
  Pacer pacer(execution);
  Support out;
  out.asked = options;
  out.loads.resize(set.bonds.size());

  std::unordered_map<std::uint64_t, std::uint32_t> index_of;  // only queried
  index_of.reserve(n);
  for (std::uint32_t f = 0; f < n; ++f) {
    pacer.step(4);
    index_of.emplace(set.fragments[f].id, f);
  }
  std::vector<char> gone(n, 0);
  for (const std::uint64_t id : options.broken) {
    pacer.step(4);
    const auto at = index_of.find(id);
    if (at == index_of.end())
      ++out.unknown;
    else
      gone[at->second] = 1;
  }
  clear_nodes(pacer, index_of);

  // Connected components, and which of them are held.
  std::vector<Bond> bonds;  // remaining bonds
  std::vector<std::uint32_t> bond_of;
  for (std::uint32_t k = 0; k < set.bonds.size(); ++k) {
    pacer.step(2);
    if (gone[set.bonds[k].a] || gone[set.bonds[k].b]) continue;
    bonds.push_back(set.bonds[k]);
    bond_of.push_back(k);
  }
  std::vector<BondGraph::Node> nodes;
  for (const Fragment& f : set.fragments) nodes.push_back({f.mass.volume, f.mass.center_of_mass});
  const std::vector<std::uint32_t> component =
      BondGraph(std::move(nodes), bonds, execution).components(execution);
  std::vector<char> held(n, 0), fixed(n, 0);
  for (std::size_t f = 0; f < n; ++f)
    if (anchored.contains(f) && !gone[f]) {
      ++out.anchored;
      held[component[f]] = 1;
    }
  for (std::uint32_t f = 0; f < n; ++f) {
    const bool stands = !gone[f] && held[component[f]];
    if (!stands && !gone[f]) out.falling.push_back(f);
    fixed[f] = static_cast<char>(!stands || anchored.contains(f));
  }

  Box box;
  for (const Fragment& f : set.fragments) box.add(f.mass.center_of_mass);
  const double size = box.longest_side() > 0 ? box.longest_side() : 1;
  std::vector<Beam> beams;
  for (std::size_t k = 0; k < bonds.size(); ++k) {
    pacer.step(4);
    const Bond& b = bonds[k];
    if (!held[component[b.a]] || (fixed[b.a] && fixed[b.b])) continue;
    const Vec3d &ca = set.fragments[b.a].mass.center_of_mass, &cb = set.fragments[b.b].mass.center_of_mass;
    const double area = b.area / (size * size), second = area * area / (4 * kPi);
    const double l = std::max(length(cb - ca) / size, 1e-6);
    beams.push_back({b.a, b.b, bond_of[k], (1 / size) * (b.centroid - ca), (1 / size) * (b.centroid - cb),
                     b.normal, area / l, kShearModulus * area / l, second / l,
                     2 * kShearModulus * second / l});
  }
  if (beams.empty()) return out;

  std::vector<Six> weight(n);
  for (std::size_t f = 0; f < n; ++f)
    weight[f].linear =
        (options.density * set.fragments[f].density_share * set.fragments[f].mass.volume) * options.gravity;
  const Network network(n, beams, fixed, pacer);
  std::vector<Six> x;
  out.residual = network.solve_for(weight, x);
  for (const Beam& beam : beams) {
    pacer.step(4);
    out.loads[beam.bond] =
        load_of(beam, beam.pull(beam.stretch(x[beam.a], x[beam.b])), set.bonds[beam.bond].area, size);
  }

  for (std::uint32_t k = 0; k < out.loads.size(); ++k)
    if (out.loads[k].stress > options.strength * set.bonds[k].strength) out.weak.push_back(k);
  sort_with_polls(execution, out.weak.begin(), out.weak.end(), [&](std::uint32_t a, std::uint32_t b) {
    const double x_a = out.loads[a].stress / set.bonds[a].strength,
                 x_b = out.loads[b].stress / set.bonds[b].strength;
    return x_a != x_b ? x_a > x_b : a < b;
  });
  return out;
}

}  // namespace fracture
