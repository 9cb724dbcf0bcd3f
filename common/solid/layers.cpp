#include "common/solid/layers.hpp"

#include <algorithm>

namespace fracture::solid_detail {

std::uint32_t assign_layers(std::vector<Part>& parts) {
  std::vector<std::uint32_t> order(parts.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return parts[a].box.min.x != parts[b].box.min.x ? parts[a].box.min.x < parts[b].box.min.x : a < b;
  });
  std::vector<std::uint32_t> open;
  std::vector<std::uint32_t> taken_by;  // per layer: the last part (plus one) that found it taken
  std::uint32_t layers = 0;
  for (const std::uint32_t i : order) {
    std::size_t kept = 0;
    taken_by.resize(layers, 0);
    for (const std::uint32_t j : open) {
      if (parts[j].box.max.x < parts[i].box.min.x) continue;
      open[kept++] = j;
      if (parts[j].box.intersects(parts[i].box)) taken_by[parts[j].layer] = i + 1;
    }
    open.resize(kept);
    open.push_back(i);
    std::uint32_t layer = 0;
    while (layer < layers && taken_by[layer] == i + 1) ++layer;
    parts[i].layer = layer;
    layers = std::max(layers, layer + 1);
  }
  return layers;
}

}  // namespace fracture::solid_detail
