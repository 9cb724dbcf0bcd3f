#include "common/solid/mirrors.hpp"

#include <array>
#include <cstdint>
#include <tuple>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/solid/polled.hpp"

namespace fracture::solid_detail {
namespace {

bool before(const Vec3f& a, const Vec3f& b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); }

}  // namespace

std::vector<TriangleId> find_mirrors(const Surface& surface, const std::vector<TriangleId>& triangles,
                                     const Execution& execution) {
  struct Entry {
    std::array<Vec3f, 3> key;
    bool odd;
    TriangleId triangle;
  };
  std::vector<Entry> entries;
  entries.reserve(triangles.size());
  for_each_polled(execution, triangles.size(), [&](std::size_t i) {
    const TriangleId t = triangles[i];
    Entry e{{}, false, t};
    for (int k = 0; k < 3; ++k) e.key[k] = surface.positions[surface.triangles[t][k]];
    for (const auto& [a, b] : {std::pair{0, 1}, std::pair{1, 2}, std::pair{0, 1}})
      if (before(e.key[b], e.key[a])) {
        std::swap(e.key[a], e.key[b]);
        e.odd = !e.odd;
      }
    entries.push_back(e);
  });
  const auto less = [](const Entry& a, const Entry& b) {
    for (int k = 0; k < 3; ++k) {
      if (before(a.key[k], b.key[k])) return true;
      if (before(b.key[k], a.key[k])) return false;
    }
    return a.triangle < b.triangle;
  };
  sort_with_polls(execution, entries.begin(), entries.end(), less);
  std::vector<TriangleId> mirror = filled(execution, surface.triangles.size(), kNoTriangle);
  for_each_polled(execution, entries.size(), [&](std::size_t i) {
    if (i + 1 < entries.size() && entries[i].key == entries[i + 1].key &&
        entries[i].odd != entries[i + 1].odd && mirror[entries[i].triangle] == kNoTriangle) {
      mirror[entries[i].triangle] = entries[i + 1].triangle;
      mirror[entries[i + 1].triangle] = entries[i].triangle;
    }
  });
  return mirror;
}

}  // namespace fracture::solid_detail
