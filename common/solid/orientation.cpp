#include "common/solid/orientation.hpp"

#include "common/base/pacer.hpp"
#include "common/solid/polled.hpp"

namespace fracture::solid_detail {

bool orient_patches(Surface& surface, const EdgeTable& edges, SolidReport& report,
                    const Execution& execution) {
  const std::size_t count = surface.triangles.size();
  constexpr std::uint32_t kSameWay = 1;
  // Per half-edge: the neighbour's half-edge << 1 | kSameWay if both have the same direction.
  std::vector<std::uint64_t> across = filled<std::uint64_t>(execution, 3 * count, ~0ull);
  bool inconsistent = false;
  edges.for_each(execution, [&](VertexId, VertexId, std::span<const EdgeUse> uses) {
    if (uses.size() != 2) return;
    const std::uint64_t same = uses[0].backward() == uses[1].backward() ? kSameWay : 0;
    inconsistent |= same != 0;
    across[uses[0].half_edge()] = static_cast<std::uint64_t>(uses[1].half_edge()) << 1 | same;
    across[uses[1].half_edge()] = static_cast<std::uint64_t>(uses[0].half_edge()) << 1 | same;
  });
  if (!inconsistent) return false;

  // 0: unchanged, 1: reversed relative to the patch's lowest triangle, 2: not visited
  std::vector<std::uint8_t> state = filled<std::uint8_t>(execution, count, 2);
  Pacer pacer(execution);
  std::vector<TriangleId> patch;
  std::size_t flipped = 0;
  for (const TriangleId seed : ids<TriangleId>(count)) {
    pacer.step();
    if (state[seed] != 2) continue;
    patch.assign(1, seed);
    state[seed] = 0;
    std::size_t reversed = 0;
    for (std::size_t i = 0; i < patch.size(); ++i) {
      pacer.step();
      for (HalfEdge h = 3 * patch[i]; h < 3 * patch[i] + 3; ++h) {
        if (across[h] == ~0ull) continue;
        const TriangleId neighbour{(across[h] >> 1) / 3};
        if (state[neighbour] != 2) continue;
        state[neighbour] = state[patch[i]] ^ static_cast<std::uint8_t>(across[h] & kSameWay);
        reversed += state[neighbour];
        patch.push_back(neighbour);
      }
    }
    const std::uint8_t minority = 2 * reversed > patch.size() ? 0 : 1;
    for (const TriangleId t : patch) {
      pacer.step();
      if (state[t] != minority) continue;
      if (flipped++ == 0) report.add_sample("flipped", surface.positions[surface.triangles[t][0]]);
      surface.flip(t);
    }
  }
  report.flipped += flipped;
  return flipped > 0;
}

}  // namespace fracture::solid_detail
