#include "common/solid/winding.hpp"

#include <algorithm>
#include <cmath>

#include "common/solid/float_predicates.hpp"
#include "common/solid/polled.hpp"

namespace fracture::solid_detail {
namespace {

/// The side of the line ab (in the plane of y and z) on which the point (p.y + ε, p.z + ε²) is; 0 only if a
/// and b coincide.
int side(const Vec3f& a, const Vec3f& b, const Vec3f& p) {
  const int sign = sign_orient2d(drop_axis(a, 0), drop_axis(b, 0), drop_axis(p, 0));
  if (sign != 0) return sign;
  // orient2d = (by - ay)(pz - az) - (bz - az)(py - ay): the coefficient of ε is -(bz - az), and that of ε² is
  // (by - ay).
  if (a.z != b.z) return a.z > b.z ? 1 : -1;
  return b.y > a.y ? 1 : b.y < a.y ? -1 : 0;
}

/// Sum of e eᵀ over edges e.
struct EdgeSpread {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  void add(const Vec3d& e) {
    xx += e.x * e.x, xy += e.x * e.y, xz += e.x * e.z;
    yy += e.y * e.y, yz += e.y * e.z, zz += e.z * e.z;
  }
  /// The unit direction in which the sum is largest (power iteration by squaring).
  Vec3d principal() const {
    Vec3d rows[3] = {{xx, xy, xz}, {xy, yy, yz}, {xz, yz, zz}};
    for (int i = 0; i < 8; ++i) {
      const double trace = rows[0].x + rows[1].y + rows[2].z;
      if (!(trace > 0)) return {1, 0, 0};
      Vec3d square[3];
      for (int r = 0; r < 3; ++r)
        square[r] = (1 / (trace * trace)) * (rows[r].x * rows[0] + rows[r].y * rows[1] + rows[r].z * rows[2]);
      std::copy(square, square + 3, rows);
    }
    const Vec3d* longest = std::max_element(
        rows, rows + 3, [](const Vec3d& a, const Vec3d& b) { return dot(a, a) < dot(b, b); });
    const double l = length(*longest);
    return l > 0 ? (1 / l) * *longest : Vec3d{1, 0, 0};
  }
};

}  // namespace

int ray_crossing(const Vec3f& p, const std::array<Vec3f, 3>& triangle, bool& clear) {
  const auto& [a, b, c] = triangle;
  if (std::max({a.y, b.y, c.y}) < p.y || std::min({a.y, b.y, c.y}) > p.y || std::max({a.z, b.z, c.z}) < p.z ||
      std::min({a.z, b.z, c.z}) > p.z || std::max({a.x, b.x, c.x}) < p.x)
    return 0;
  const int ab = side(a, b, p), bc = side(b, c, p), ca = side(c, a, p);
  if (ab != bc || bc != ca) return 0;  // the ray misses it; a triangle seen edge-on has mixed signs
  if (ab == 0) {                       // on the ray's line: the ray misses it, but p may be on it
    clear &= std::min({a.x, b.x, c.x}) > p.x;
    return 0;
  }
  // Projected along +x, a triangle whose normal points to +x is counter-clockwise. So ab > 0 means that the
  // ray leaves through it.
  const int height = sign_orient3d(a, b, c, p);
  if (height == 0) clear = false;
  return height * ab >= 0 ? 0 : ab;  // otherwise the triangle is at p or before it
}

WindingNumbers::WindingNumbers(const Surface& surface, const Shells& shells, const Execution& execution)
    : surface_(surface), shells_(shells), pacer_(execution) {
  const std::size_t count = shells.list.size(), triangles = surface.triangles.size();
  start_ = filled<std::uint32_t>(execution, count + 2, 0);  // shifted by one until the triangles are placed
  for_each_polled(execution, triangles, [&](std::size_t t) { ++start_[shells.of_triangle[t] + 2]; });
  for (std::size_t s = 2; s < start_.size(); ++s) start_[s] += start_[s - 1];
  triangles_ = filled(execution, triangles, TriangleId{0});
  for_each_polled(execution, triangles,
                  [&](std::size_t t) { triangles_[start_[shells.of_triangle[t] + 1]++] = TriangleId{t}; });
  start_.pop_back();

  const auto edge = [&](std::size_t t, int k) {
    const Triangle& corners = surface.triangles[t];
    return to_double(surface.positions[corners[(k + 1) % 3]]) - to_double(surface.positions[corners[k]]);
  };
  EdgeSpread spread, rest;
  for_each_polled(execution, triangles, [&](std::size_t t) {
    for (int k = 0; k < 3; ++k) spread.add(edge(t, k));
  });
  const Vec3d along = spread.principal();
  for_each_polled(execution, triangles, [&](std::size_t t) {
    for (int k = 0; k < 3; ++k) rest.add(edge(t, k) - dot(edge(t, k), along) * along);
  });
  across_[0] = rest.principal();
  across_[1] = cross(along, across_[0]);
  double largest = 0;
  oblique_ = filled(execution, count, Slabs<2>{{{HUGE_VAL, -HUGE_VAL}, {HUGE_VAL, -HUGE_VAL}}});
  for_each_polled(execution, triangles, [&](std::size_t t) {
    for (const VertexId v : surface.triangles[t]) {
      const Vec3d p = to_double(surface.positions[v]);
      for (int a = 0; a < 3; ++a) largest = std::max(largest, std::fabs(p[a]));
      for (int k = 0; k < 2; ++k) {
        auto& [low, high] = oblique_[shells.of_triangle[t]][k];
        low = std::min(low, dot(across_[k], p));
        high = std::max(high, dot(across_[k], p));
      }
    }
  });
  margin_ = 1e-14 * largest;  // the error of three products and two sums is at most 9 · 2^-53 · largest

  std::vector<std::uint32_t> all(count);
  large_of_shell_.assign(count, kNoIndex);
  for (std::uint32_t s = 0; s < count; ++s) {
    all[s] = s;
    if (shells.list[s].triangles <= kSmallShell) continue;
    large_of_shell_[s] = static_cast<std::uint32_t>(large_.size());
    large_.emplace_back();
  }
  tree_ = std::make_unique<ShellTree>(
      std::move(all), [this](std::uint32_t s) { return shell_slabs(s); }, pacer_);
}

Slabs<5> WindingNumbers::shell_slabs(std::uint32_t shell) const {
  const Box& box = shells_.list[shell].box;
  const Slabs<2>& oblique = oblique_[shell];
  return {{{box.min.x, box.max.x},
           {box.min.y, box.max.y},
           {box.min.z, box.max.z},
           {oblique[0][0] - margin_, oblique[0][1] + margin_},
           {oblique[1][0] - margin_, oblique[1][1] + margin_}}};
}

const std::vector<WindingNumbers::Wind>& WindingNumbers::around(std::uint32_t i) {
  const std::uint32_t end = std::min(start_[i + 1], start_[i] + kProbes);
  bool clear = false, current = false;  // current: winds_ belongs to the last corner tried
  Vec3f p;
  for (std::uint32_t k = start_[i]; k < end && !clear; ++k)
    for (int corner = 0; corner < 3 && !clear; ++corner) {
      p = surface_.positions[surface_.triangles[triangles_[k]][corner]];
      const auto known = shared_.find({p.x, p.y, p.z});
      current = known == shared_.end() || known->second.clear_of(i);
      if (!current) continue;
      const Contacts contacts = cast(p, i);
      clear = contacts.clear_of(i);
      if (!clear) shared_.emplace(std::array{p.x, p.y, p.z}, contacts);
    }
  if (!current) cast(p, i);
  std::sort(winds_.begin(), winds_.end(), [](const Wind& a, const Wind& b) { return a.shell < b.shell; });
  return winds_;
}

/// Fills winds_, and returns the shells that contain p on their surface.
WindingNumbers::Contacts WindingNumbers::cast(const Vec3f& p, std::uint32_t self) {
  winds_.clear();
  Contacts contacts;
  const Vec3d q = to_double(p);
  const double across[2] = {dot(across_[0], q), dot(across_[1], q)};
  tree_->for_each_near({q.x, q.y, q.z, across[0], across[1]}, [&](std::uint32_t shell) {
    ++work_;
    const Slabs<5> slabs = shell_slabs(shell);
    for (int a = 0; a < 3; ++a)
      if (q[a] < slabs[a][0] || q[a] > slabs[a][1]) return;
    for (int k = 0; k < 2; ++k)
      if (across[k] < slabs[3 + k][0] || across[k] > slabs[3 + k][1]) return;
    bool clear = true;
    const int number = crossings(p, shell, clear);
    if (!clear) contacts.add(shell);
    if (shell != self && number != 0 && !shells_.list[shell].flat) winds_.push_back({shell, number});
  });
  return contacts;
}

int WindingNumbers::crossings(const Vec3f& p, std::uint32_t shell, bool& clear) {
  int number = 0;
  if (const std::uint32_t k = large_of_shell_[shell]; k != kNoIndex) {
    Members& members = large_[k];
    if (!members.tree && ++members.asked > 4) plant(shell, members);
    if (members.tree) {
      const Vec2d& across = members.across;
      members.tree->for_each_near({p.y, p.z, across.x * p.y + across.y * p.z, p.x},
                                  [&](std::uint32_t t) { number += crossing(p, TriangleId{t}, clear); });
      return number;
    }
  }
  for (std::uint32_t k = start_[shell]; k < start_[shell + 1]; ++k) {
    number += crossing(p, triangles_[k], clear);
  }
  return number;
}

int WindingNumbers::crossing(const Vec3f& p, TriangleId t, bool& clear) {
  pacer_.step();
  ++work_;
  const Triangle& v = surface_.triangles[t];
  return ray_crossing(p, {surface_.positions[v[0]], surface_.positions[v[1]], surface_.positions[v[2]]},
                      clear);
}

int WindingNumbers::number(std::uint32_t shell, const Vec3f& p) {
  bool clear = true;
  return crossings(p, shell, clear);
}

void WindingNumbers::plant(std::uint32_t shell, Members& members) {
  const auto begin = triangles_.begin() + start_[shell], end = triangles_.begin() + start_[shell + 1];
  const auto corner = [this](TriangleId t, int k) {
    const Vec3f& p = surface_.positions[surface_.triangles[t][k]];
    return Vec3d{0, p.y, p.z};
  };
  EdgeSpread spread;
  for (auto t = begin; t != end; ++t) {
    pacer_.step();
    for (int k = 0; k < 3; ++k) spread.add(corner(*t, (k + 1) % 3) - corner(*t, k));
  }
  const Vec3d along = spread.principal();
  members.across = {-along.z, along.y};
  const auto slabs_of = [&](std::uint32_t t) {
    Slabs<4> slabs;
    slabs.fill({HUGE_VAL, -HUGE_VAL});
    slabs[3] = {-HUGE_VAL, -HUGE_VAL};
    for (const VertexId v : surface_.triangles[t]) {
      const Vec3f& p = surface_.positions[v];
      const double oblique = members.across.x * p.y + members.across.y * p.z;
      const std::array<std::array<double, 2>, 3> values{
          {{p.y, p.y}, {p.z, p.z}, {oblique - margin_, oblique + margin_}}};
      for (int k = 0; k < 3; ++k) {
        slabs[k][0] = std::min(slabs[k][0], values[k][0]);
        slabs[k][1] = std::max(slabs[k][1], values[k][1]);
      }
      slabs[3][1] = std::max<double>(slabs[3][1], p.x);
    }
    return slabs;
  };
  members.tree = std::make_unique<TriangleTree>(std::vector<std::uint32_t>(begin, end), slabs_of, pacer_);
}

}  // namespace fracture::solid_detail
