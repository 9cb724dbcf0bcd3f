#include "common/clip/pinched_ring.hpp"

#include <map>
#include <utility>

namespace fracture {

// Each run of successive corners at the same position becomes its first corner:
//
//      p1 = p2 = p3 ---> q     The triangles (p1, p2, p3) and (p1, p3, q) have no area and use the edges
//                              p1 p2, p2 p3 and p3 q; the rest of the ring goes from p1 to q.
std::vector<std::uint32_t> leave_out_repeated(std::span<const LatticePoint> points,
                                              std::span<const std::uint32_t> ring,
                                              std::vector<std::array<std::uint32_t, 3>>& triangles) {
  const std::size_t n = ring.size();
  const auto at = [&](std::size_t k) { return ring[k % n]; };
  // Begin at the start of a run, so that no run crosses the end.
  std::size_t first = 0;
  while (first < n && points[at(first)] == points[at(first + n - 1)]) ++first;
  if (first == n) first = 0;  // all corners are at one position: a fan without area
  std::vector<std::uint32_t> kept;
  for (std::size_t k = first; k < first + n; ++k) {
    const std::uint32_t v = at(k), next = at(k + 1);
    if (kept.empty() || !(points[kept.back()] == points[v]))
      kept.push_back(v);
    else if (kept.back() != v && v != next && next != kept.back())
      triangles.push_back({kept.back(), v, next});
  }
  return kept;
}

void divide_pinched_ring(std::span<const LatticePoint> points, std::span<const std::uint32_t> ring,
                         std::vector<std::vector<std::uint32_t>>& rings,
                         std::vector<std::array<std::uint32_t, 3>>& triangles) {
  // The ring so far, without the rings that were split off, and twice the area that it has swept, seen from
  // its first corner.
  std::vector<std::uint32_t> open;
  std::vector<__int128> swept;
  std::map<std::pair<std::int64_t, std::int64_t>, std::size_t> visited;  // position -> index in `open`
  const auto add = [&](const std::vector<std::uint32_t>& part) {
    std::vector<std::uint32_t> kept = leave_out_repeated(points, part, triangles);
    if (kept.size() > 2) rings.push_back(std::move(kept));
  };
  const auto place = [&](std::uint32_t v) { return std::pair{points[v].x, points[v].y}; };
  for (const std::uint32_t v : ring) {
    const __int128 sum =
        open.empty() ? 0 : swept.back() + orient2d(points[ring[0]], points[open.back()], points[v]);
    const auto [at, fresh] = visited.try_emplace(place(v), open.size());
    if (!fresh && open.size() - at->second > 1 && sum >= swept[at->second]) {
      const std::size_t from = at->second;
      std::vector<std::uint32_t> off(open.begin() + static_cast<std::ptrdiff_t>(from), open.end());
      off.push_back(v);
      for (std::size_t k = from + 1; k < open.size(); ++k) {
        const auto gone = visited.find(place(open[k]));
        if (gone != visited.end() && gone->second == k) visited.erase(gone);
      }
      open.resize(from + 1);
      swept.resize(from + 1);
      add(off);
      open.push_back(v);
      swept.push_back(swept.back());
      continue;
    }
    open.push_back(v);
    swept.push_back(sum);
  }
  add(open);
}

}  // namespace fracture
