#include "common/fragment/mirror_sum.hpp"

#include <algorithm>
#include <array>

#include "common/base/pacer.hpp"
#include "common/base/random.hpp"
#include "common/base/scratch.hpp"
#include "common/fragment/float_bits.hpp"

namespace fracture {
namespace {

using Place = std::array<std::uint32_t, 3>;  // the bits of a position in world space

/// World position as a reader of the file computes it: local + translation, in float.
Place world(const Fragment& f, const Vec3f& pivot, std::uint32_t v) {
  const Vec3f& p = f.positions[v];
  return {bits_of(p.x + pivot.x), bits_of(p.y + pivot.y), bits_of(p.z + pivot.z)};
}

Vec3f translation(const Fragment& f) {
  return {static_cast<float>(f.pivot.x), static_cast<float>(f.pivot.y), static_cast<float>(f.pivot.z)};
}

std::uint64_t hash(const Place& p) {
  std::uint64_t h = (p[0] | static_cast<std::uint64_t>(p[1]) << 32) * kGoldenGamma;
  h = (h ^ (h >> 32) ^ p[2]) * 0xbf58476d1ce4e5b9ull;
  return h ^ (h >> 29);
}

struct Hashes {
  std::vector<std::uint64_t> of_vertices;
  std::size_t bytes() const { return bytes_of_vectors(of_vertices); }
  void release() { release_vectors(of_vertices); }
};

}  // namespace

// Adds up a determinant per triangle, with the rows (h, h², h³) for its three corners. It changes its sign
// with the orientation. Unlike a plain Vandermonde determinant, it is not a sum over the edges, which would
// cancel over any two closed surfaces.
std::uint64_t mirror_sum(const Fragment& f, const Execution& execution) {
  Pacer pacer(execution);
  const Vec3f pivot = translation(f);
  std::uint64_t sum = 0;
  for (const IndexRange& range : f.caps) {
    const std::uint32_t* const first = f.indices.data() + range.first;
    const std::uint32_t* const last = first + range.count;
    // The vertices of a range of caps are consecutive.
    const auto [low, high] = std::minmax_element(first, last);
    std::vector<std::uint64_t>& hashes = thread_scratch<Hashes>().of_vertices;
    hashes.clear();
    pacer.step(*high - *low + range.count);
    for (std::uint32_t v = *low; v <= *high; ++v) hashes.push_back(hash(world(f, pivot, v)));
    const std::uint64_t* const of = hashes.data() - *low;
    for (const std::uint32_t* at = first; at != last; at += 3) {
      const std::uint64_t a = of[at[0]], b = of[at[1]], c = of[at[2]];
      sum += (a * b * c) * ((b - a) * (c - a)) * (c - b);
    }
  }
  return sum;
}

std::vector<std::uint32_t> unmirrored(const std::vector<Fragment>& fragments, std::uint64_t& count) {
  struct Entry {
    // Starting at the least, in the direction in which the second is less than the third
    std::array<Place, 3> corners;
    bool turned;
    std::uint32_t fragment;
  };
  std::vector<Entry> entries;
  for (std::uint32_t n = 0; n < fragments.size(); ++n) {
    const Fragment& f = fragments[n];
    const Vec3f pivot = translation(f);
    for (const IndexRange& range : f.caps)
      for (std::uint32_t k = range.first; k < range.first + range.count; k += 3) {
        Entry e{{world(f, pivot, f.indices[k]), world(f, pivot, f.indices[k + 1]),
                 world(f, pivot, f.indices[k + 2])},
                false,
                n};
        auto& c = e.corners;
        if (c[0] == c[1] || c[1] == c[2] || c[2] == c[0]) continue;
        std::rotate(c.begin(), std::min_element(c.begin(), c.end()), c.end());
        e.turned = c[2] < c[1];
        if (e.turned) std::swap(c[1], c[2]);
        entries.push_back(e);
      }
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.corners != b.corners ? a.corners < b.corners : a.fragment < b.fragment;
  });
  count = 0;
  std::vector<std::uint32_t> concerned;
  for (std::size_t k = 0; k < entries.size();) {
    std::int64_t balance = 0;
    const std::size_t first = k;
    for (; k < entries.size() && entries[k].corners == entries[first].corners; ++k)
      balance += entries[k].turned ? -1 : 1;
    if (balance == 0) continue;
    count += static_cast<std::uint64_t>(balance < 0 ? -balance : balance);
    for (std::size_t m = first; m < k; ++m) concerned.push_back(entries[m].fragment);
  }
  std::sort(concerned.begin(), concerned.end());
  concerned.erase(std::unique(concerned.begin(), concerned.end()), concerned.end());
  return concerned;
}

}  // namespace fracture
