#include "tests/property/violations.hpp"
#include "common/solid/cut_materials.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <tuple>

#include "common/solid/solid.hpp"

namespace fracture::test {
namespace {

using Key = std::tuple<float, float, float>;

Key key(const Vec3f& p) { return {p.x, p.y, p.z}; }  // -0 == 0

Vec3f world(const Fragment& f, std::uint32_t v) {
  const Vec3f& p = f.positions[v];
  return {p.x + static_cast<float>(f.pivot.x), p.y + static_cast<float>(f.pivot.y),
          p.z + static_cast<float>(f.pivot.z)};
}

template <class Name>
std::int64_t unbalanced_edges(const Fragment& f, const Name& name) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> balance;
  for (std::size_t k = 0; k < f.indices.size(); k += 3)
    for (int e = 0; e < 3; ++e) {
      const std::uint32_t a = name(f.indices[k + e]), b = name(f.indices[k + (e + 1) % 3]);
      if (a != b) balance[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  std::int64_t n = 0;
  for (const auto& [edge, sum] : balance) n += sum != 0;
  return n;
}

/// Counts repeated uses of directed edges between the names of corners, and triangles with two corners of one
/// name.
template <class Name>
std::int64_t repeated_uses(const Fragment& f, const Name& name) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> seen;
  std::int64_t n = 0;
  for (std::size_t k = 0; k < f.indices.size(); k += 3)
    for (int e = 0; e < 3; ++e) {
      const std::uint32_t a = name(f.indices[k + e]), b = name(f.indices[k + (e + 1) % 3]);
      n += a == b || !seen.emplace(a, b).second;
    }
  return n;
}

/// Sentences about violations. Only the first dozen are kept, because one broken fragment can break thousands
/// of statements.
class Sentences {
 public:
  template <class... Figures>
  void add(const char* format, Figures... figures) {
    if (++count_ > kKept) return;
    char text[240];
    std::snprintf(text, sizeof text, format, figures...);
    sentences_.emplace_back(text);
  }
  Violations all() {
    if (count_ > kKept) sentences_.push_back("and " + std::to_string(count_ - kKept) + " more like these");
    return std::move(sentences_);
  }

 private:
  static constexpr std::size_t kKept = 12;
  std::size_t count_ = 0;
  Violations sentences_;
};

}  // namespace

Violations closed_violations(const FragmentSet& set) {
  Sentences broken;
  for (std::size_t n = 0; n < set.fragments.size(); ++n) {
    const Fragment& f = set.fragments[n];
    if (const auto open = unbalanced_edges(f, [&](std::uint32_t v) { return f.topology[v]; }))
      broken.add("fragment %zu: %lld open edges in its own topology", n, static_cast<long long>(open));
    if (const auto uses = repeated_uses(f, [&](std::uint32_t v) { return f.topology[v]; }))
      broken.add("fragment %zu: %lld directed edges used again in its own topology", n,
                 static_cast<long long>(uses));
    std::map<Key, std::uint32_t> first;
    std::vector<std::uint32_t> weld;
    for (std::uint32_t v = 0; v < f.positions.size(); ++v)
      weld.push_back(first.try_emplace(key(f.positions[v]), v).first->second);
    if (const auto open = unbalanced_edges(f, [&](std::uint32_t v) { return weld[v]; }))
      broken.add("fragment %zu: %lld open edges after welding", n, static_cast<long long>(open));
    long double six = 0;
    for (std::size_t k = 0; k < f.indices.size(); k += 3) {
      const Vec3d a = to_double(f.positions[f.indices[k]]), b = to_double(f.positions[f.indices[k + 1]]),
                  c = to_double(f.positions[f.indices[k + 2]]);
      six += static_cast<long double>(a.x) *
                 (static_cast<long double>(b.y) * c.z - static_cast<long double>(b.z) * c.y) +
             static_cast<long double>(a.y) *
                 (static_cast<long double>(b.z) * c.x - static_cast<long double>(b.x) * c.z) +
             static_cast<long double>(a.z) *
                 (static_cast<long double>(b.x) * c.y - static_cast<long double>(b.y) * c.x);
    }
    if (!(six > 0)) broken.add("fragment %zu: volume %.9g", n, static_cast<double>(six / 6));
  }
  return broken.all();
}

Violations partition_violations(const FragmentSet& set, const Whole& whole) {
  Sentences broken;
  double unrounded = 0, file = 0;
  std::map<std::array<Key, 3>, int> seams;
  for (const Fragment& f : set.fragments) {
    unrounded += f.mass.volume;
    double six = 0;
    for (std::size_t k = 0; k < f.indices.size(); k += 3)
      six += dot(to_double(f.positions[f.indices[k]]),
                 cross(to_double(f.positions[f.indices[k + 1]]), to_double(f.positions[f.indices[k + 2]])));
    file += six / 6;
    for (const FragmentPrimitive& p : f.primitives) {
      if (!is_of_cuts(p.material)) continue;
      for (std::uint32_t k = p.first_index; k < p.first_index + p.index_count; k += 3) {
        std::array<Key, 3> t;
        for (std::uint32_t c = 0; c < 3; ++c) {
          const std::uint32_t v = f.indices[k + c];
          const Vec3f w = world(f, v);
          const Vec3d exact = to_double(f.positions[v]) + f.pivot;
          if (to_double(w) != exact)
            broken.add("fragment %llu: local + pivot rounds", static_cast<unsigned long long>(f.id));
          t[c] = key(w);
        }
        // A triangle with two corners at one place is its own mirror image.
        if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
        // Starts at the smallest corner. The triangle then either cancels one that runs the other way or counts once.
        std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
        const auto mirrored = seams.find({t[0], t[2], t[1]});
        if (mirrored != seams.end() && mirrored->second > 0)
          --mirrored->second;
        else
          ++seams[t];
      }
    }
  }
  const Certificate& certificate = set.certificate;
  unrounded += certificate.pocket_volume;
  file += certificate.pocket_volume;
  if (!(std::fabs(unrounded - whole.volume) <= 1e-9 * whole.magnitude))
    broken.add("volume before rounding: %.17g m3, of the solid %.17g", unrounded, whole.volume);
  const double h = std::max({set.lattice_step.x, set.lattice_step.y, set.lattice_step.z});
  const double bound = 2 * h * (whole.area + certificate.pocket_area);
  if (!(std::fabs(file - whole.volume) <= bound))
    broken.add("volume in the file: %.9g m3, of the solid %.9g, bound %.3g", file, whole.volume, bound);
  int unpaired = 0;
  for (const auto& [corners, count] : seams) unpaired += count;
  if (unpaired != 0 && !whole.filled) broken.add("%d interior triangles without mirror image", unpaired);
  return broken.all();
}

Violations outside_violations(const FragmentSet& set, const Mesh& traced, bool everything) {
  Sentences broken;
  const std::size_t n = traced.triangles.size();
  std::vector<double> covered(n, 0);
  const Vec3d h = set.lattice_step;
  const double reach = 2 * (h.x + h.y + h.z);
  for (const Fragment& f : set.fragments)
    for (const FragmentPrimitive& p : f.primitives) {
      if (is_of_cuts(p.material)) continue;
      if (p.material >= n) {
        broken.add("an exterior triangle of no triangle of the mesh: %u", p.material);
        return broken.all();
      }
      const auto& corners = traced.triangles[p.material];
      const Vec3d a = to_double(traced.positions[corners[0]]), b = to_double(traced.positions[corners[1]]),
                  c = to_double(traced.positions[corners[2]]);
      Vec3d normal = cross(b - a, c - a);
      const double l = length(normal);
      if (l > 0) normal = (1 / l) * normal;
      Box box;
      for (const Vec3d& q : {a, b, c}) box.add(q);
      for (std::uint32_t k = p.first_index; k < p.first_index + p.index_count; k += 3) {
        Vec3d x[3];
        for (std::uint32_t m = 0; m < 3; ++m) {
          const Vec3f w = world(f, f.indices[k + m]);
          x[m] = to_double(w);
          if (l > reach * reach && !(std::fabs(dot(x[m] - a, normal)) <= reach))
            broken.add("%.3g m off the plane of triangle %u", dot(x[m] - a, normal), p.material);
          for (int axis = 0; axis < 3; ++axis)
            if (!(x[m][axis] >= box.min[axis] - reach && x[m][axis] <= box.max[axis] + reach))
              broken.add("outside the box of triangle %u", p.material);
        }
        if (l > 0) covered[p.material] += 0.5 * dot(cross(x[1] - x[0], x[2] - x[0]), normal);
      }
    }
  for (std::size_t t = 0; t < n; ++t) {
    const auto& v = traced.triangles[t];
    const Vec3d a = to_double(traced.positions[v[0]]), b = to_double(traced.positions[v[1]]),
                c = to_double(traced.positions[v[2]]);
    const double area = 0.5 * length(cross(b - a, c - a)),
                 perimeter = length(b - a) + length(c - b) + length(a - c);
    const double slack = 2 * reach * perimeter + reach * reach;
    if (!(covered[t] <= area + slack) || (everything && !(covered[t] >= area - slack)))
      broken.add("triangle %zu of %.9g m2 is covered by %.9g", t, area, covered[t]);
  }
  return broken.all();
}

}  // namespace fracture::test
