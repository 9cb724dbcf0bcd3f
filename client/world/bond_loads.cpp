#include "client/world/bond_loads.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/disjoint_sets.hpp"

namespace fracture::world {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr double kTolerance = 1e-3;  ///< relative residual: strengths are known to one digit at best
constexpr int kMaxIterations = 60;   ///< keeps the worst case of 500 fragments near a millisecond

struct Spring {
  std::uint32_t a, b;  ///< positions among the case's members
  double stiffness;
};

/// Conjugate gradients with Jacobi's preconditioner, for three right-hand sides at once that share the
/// matrix.
class SpringNetwork {
 public:
  SpringNetwork(std::span<const Spring> springs, const std::vector<bool>& held, std::vector<double> inertia)
      : springs_(springs), held_(held), inertia_(std::move(inertia)), diagonal_(inertia_) {
    for (const Spring& s : springs_) {
      diagonal_[s.a] += s.stiffness;
      diagonal_[s.b] += s.stiffness;
    }
  }

  /// Solves (L + inertia) u = force for u, with L = Σ k (u_a − u_b) … and held members at 0.
  std::vector<glm::dvec3> solve(std::vector<glm::dvec3> residual) const {
    const std::size_t n = held_.size();
    std::vector<glm::dvec3> u(n, glm::dvec3(0)), z(n), p(n), lp(n);
    for (std::size_t k = 0; k < n; ++k)
      if (held_[k] || diagonal_[k] == 0) residual[k] = glm::dvec3(0);
    const glm::dvec3 start = dots(residual, residual);
    precondition(residual, z);
    p = z;
    glm::dvec3 rz = dots(residual, z);
    for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
      const glm::dvec3 now = dots(residual, residual);
      if (now.x + now.y + now.z <= kTolerance * kTolerance * (start.x + start.y + start.z)) break;
      apply(p, lp);
      const glm::dvec3 plp = dots(p, lp);
      glm::dvec3 alpha;
      for (int c = 0; c < 3; ++c) alpha[c] = plp[c] > 0 ? rz[c] / plp[c] : 0;
      for (std::size_t k = 0; k < n; ++k) {
        u[k] += alpha * p[k];
        residual[k] -= alpha * lp[k];
      }
      precondition(residual, z);
      const glm::dvec3 next = dots(residual, z);
      glm::dvec3 beta;
      for (int c = 0; c < 3; ++c) beta[c] = rz[c] > 0 ? next[c] / rz[c] : 0;
      for (std::size_t k = 0; k < n; ++k) p[k] = z[k] + beta * p[k];
      rz = next;
    }
    return u;
  }

 private:
  static glm::dvec3 dots(const std::vector<glm::dvec3>& a, const std::vector<glm::dvec3>& b) {
    glm::dvec3 sum(0);
    for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
    return sum;
  }
  void precondition(const std::vector<glm::dvec3>& r, std::vector<glm::dvec3>& z) const {
    for (std::size_t k = 0; k < r.size(); ++k)
      z[k] = held_[k] || diagonal_[k] == 0 ? glm::dvec3(0) : r[k] / diagonal_[k];
  }
  void apply(const std::vector<glm::dvec3>& x, std::vector<glm::dvec3>& lx) const {
    for (std::size_t k = 0; k < x.size(); ++k) lx[k] = inertia_[k] * x[k];
    for (const Spring& s : springs_) {
      const glm::dvec3 f = s.stiffness * (x[s.a] - x[s.b]);
      lx[s.a] += f;
      lx[s.b] -= f;
    }
    for (std::size_t k = 0; k < x.size(); ++k)
      if (held_[k]) lx[k] = glm::dvec3(0);
  }

  std::span<const Spring> springs_;
  const std::vector<bool>& held_;
  std::vector<double> inertia_, diagonal_;
};

/// Position among the sorted members.
std::uint32_t place(std::span<const std::uint32_t> members, std::uint32_t fragment) {
  const auto it = std::lower_bound(members.begin(), members.end(), fragment);
  return it != members.end() && *it == fragment ? static_cast<std::uint32_t>(it - members.begin()) : kNone;
}

/// A group of bonded fragments, for several load cases on the same network.
class Group {
 public:
  Group(const FragmentSet& set, const LoadCase& load) : held_(load.members.size()) {
    double volume = 0;
    for (std::size_t k = 0; k < load.members.size(); ++k) {
      const Fragment& fragment = set.fragments[load.members[k]];
      held_[k] = fragment.anchored;
      anchored_ = anchored_ || fragment.anchored;
      masses_.push_back(fragment.mass);
      volume += fragment.volume;
    }
    whole_ = combine(masses_);
    density_ = whole_.mass / volume;
    for (const std::uint32_t index : load.bonds) {
      const Bond& bond = set.bonds[index];
      const std::uint32_t a = place(load.members, bond.a), b = place(load.members, bond.b);
      const double distance = glm::distance(masses_[a].center, masses_[b].center);
      springs_.push_back({a, b, std::max(bond.area, 1e-12) / std::max(distance, 1e-6)});
    }
  }

  /// Adds to the force of each bond, as it acts on its first fragment. reach 0: unlimited.
  void add(const Forces& forces, const glm::dvec3& gravity, double reach,
           std::vector<glm::dvec3>& on_bond) const {
    const std::size_t n = held_.size();
    // The forces that the bonds must carry.
    std::vector<glm::dvec3> pull = forces.on_member;
    pull.resize(n, glm::dvec3(0));
    for (std::size_t k = 0; k < n; ++k) pull[k] += masses_[k].mass * gravity;
    if (!anchored_) {
      glm::dvec3 force(0);
      for (const glm::dvec3& f : forces.on_member) force += f;
      const glm::dvec3 acceleration = gravity + force / whole_.mass,
                       angular = glm::inverse(whole_.inertia) * forces.torque;
      for (std::size_t k = 0; k < n; ++k)
        pull[k] -= masses_[k].mass * (acceleration + glm::cross(angular, masses_[k].center - whole_.center));
    }
    std::vector<double> inertia(n, 0);
    if (reach > 0)
      for (std::size_t k = 0; k < n; ++k) inertia[k] = masses_[k].mass / (density_ * reach * reach);
    const std::vector<glm::dvec3> u = SpringNetwork(springs_, held_, inertia).solve(std::move(pull));
    for (std::size_t k = 0; k < springs_.size(); ++k)
      on_bond[k] += springs_[k].stiffness * (u[springs_[k].b] - u[springs_[k].a]);
  }

 private:
  std::vector<bool> held_;
  bool anchored_ = false;
  std::vector<MassProperties> masses_;
  MassProperties whole_;
  double density_ = 1;
  std::vector<Spring> springs_;
};

}  // namespace

std::vector<double> bond_loads(const FragmentSet& set, const LoadCase& load) {
  const Group group(set, load);
  std::vector<glm::dvec3> on_bond(load.bonds.size(), glm::dvec3(0));
  group.add(load.lasting, load.gravity, 0, on_bond);
  if (!load.hits.on_member.empty()) group.add(load.hits, glm::dvec3(0), load.reach, on_bond);
  std::vector<double> loads;
  loads.reserve(on_bond.size());
  for (std::size_t k = 0; k < on_bond.size(); ++k) {
    const Bond& bond = set.bonds[load.bonds[k]];
    const glm::dvec3& f = on_bond[k];
    const double along = glm::dot(f, bond.normal);  // > 0: tension
    const double pulled = along > 0 ? along : -kCompressionShare * along;
    const double shear = glm::length(f - along * bond.normal);
    const double all = kStressConcentration * std::sqrt(pulled * pulled + shear * shear);
    loads.push_back(bond.strength > 0 ? all / bond.strength : (all > 0 ? 1e9 : 0));
  }
  return loads;
}

std::vector<std::vector<std::uint32_t>> components(std::span<const std::uint32_t> members,
                                                   std::span<const std::uint32_t> bonds,
                                                   const FragmentSet& set) {
  DisjointSets sets(members.size());
  for (const std::uint32_t index : bonds)
    sets.unite(place(members, set.bonds[index].a), place(members, set.bonds[index].b));
  std::vector<std::uint32_t> number(members.size(), kNone);
  std::vector<std::vector<std::uint32_t>> result;
  for (std::uint32_t k = 0; k < members.size(); ++k) {
    const std::uint32_t root = sets.find(k);  // the lowest member, so it comes first
    if (number[root] == kNone) {
      number[root] = static_cast<std::uint32_t>(result.size());
      result.emplace_back();
    }
    result[number[root]].push_back(members[k]);
  }
  return result;
}

}  // namespace fracture::world
