#include "common/surface_color/color_groups.hpp"

#include <algorithm>
#include <cmath>

namespace fracture {
namespace {

constexpr std::uint32_t kSteps = 16;  // number along each axis
constexpr std::size_t kBins = std::size_t{kSteps} * kSteps * kSteps;

double root(double light) { return std::sqrt(light / 65535); }

std::uint32_t bin_of(const LinearColor& color) {
  std::uint32_t bin = 0;
  for (const std::uint16_t light : color)
    bin = kSteps * bin + std::min(kSteps - 1, static_cast<std::uint32_t>(kSteps * root(light)));
  return bin;
}

struct Item {
  std::array<double, 3> roots;
  double weight;
  std::uint32_t bin;
};

/// The items [first, last).
struct Group {
  std::size_t first, last;
  double weight = 0;
  std::size_t axis = 0;  ///< axis with the largest variance
  double gain = 0;       ///< variance times weight; 0: all colours are alike
  double mean = 0;       ///< mean along the axis
};

Group measured(const std::vector<Item>& items, std::size_t first, std::size_t last, double alike) {
  Group group{first, last};
  for (std::size_t k = first; k < last; ++k) group.weight += items[k].weight;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double low = 1, high = 0, mean = 0, squares = 0;
    for (std::size_t k = first; k < last; ++k) {
      low = std::min(low, items[k].roots[axis]);
      high = std::max(high, items[k].roots[axis]);
      mean += items[k].weight * items[k].roots[axis] / group.weight;
    }
    if (high - low <= alike) continue;
    for (std::size_t k = first; k < last; ++k) {
      const double off = items[k].roots[axis] - mean;
      squares += items[k].weight * off * off;
    }
    if (squares > group.gain) {
      group.gain = squares;
      group.axis = axis;
      group.mean = mean;
    }
  }
  return group;
}

/// Sorts the group along its axis, and returns where its upper part begins; neither part is empty.
std::size_t divide(std::vector<Item>& items, const Group& group) {
  const auto begin = items.begin() + static_cast<std::ptrdiff_t>(group.first);
  const auto end = items.begin() + static_cast<std::ptrdiff_t>(group.last);
  std::sort(begin, end, [&](const Item& a, const Item& b) {
    return a.roots[group.axis] != b.roots[group.axis] ? a.roots[group.axis] < b.roots[group.axis]
                                                      : a.bin < b.bin;
  });
  const auto above =
      std::find_if(begin + 1, end - 1, [&](const Item& item) { return item.roots[group.axis] > group.mean; });
  return static_cast<std::size_t>(above - items.begin());
}

}  // namespace

std::uint32_t ColorGroups::of(const LinearColor& color) const { return of_bin[bin_of(color)]; }

ColorHistogram::ColorHistogram() : place_(kBins) {}

void ColorHistogram::add(const LinearColor& color, double weight) {
  const std::uint32_t bin = bin_of(color);
  if (place_[bin] == 0) {
    sums_.push_back({bin});
    place_[bin] = static_cast<std::uint16_t>(sums_.size());
  }
  Sum& sum = sums_[place_[bin] - 1u];
  for (std::size_t k = 0; k < 3; ++k) sum.color[k] += weight * color[k];
  sum.weight += weight;
}

void ColorHistogram::clear() {
  for (const Sum& sum : sums_) place_[sum.bin] = 0;
  sums_.clear();
}

ColorGroups ColorHistogram::groups(std::size_t most, double alike) const {
  ColorGroups result;
  result.of_bin.resize(kBins, 0);
  if (sums_.empty()) return result;
  std::vector<Item> items;
  for (const Sum& sum : sums_) {
    Item& item = items.emplace_back(Item{{}, sum.weight, sum.bin});
    for (std::size_t k = 0; k < 3; ++k) item.roots[k] = root(sum.color[k] / sum.weight);
  }
  std::vector<Group> groups{measured(items, 0, items.size(), alike)};
  while (groups.size() < most) {
    const auto widest = std::max_element(groups.begin(), groups.end(),
                                         [](const Group& a, const Group& b) { return a.gain < b.gain; });
    if (widest->gain == 0) break;
    const Group group = *widest;
    const std::size_t middle = divide(items, group);
    *widest = measured(items, group.first, middle, alike);
    groups.push_back(measured(items, middle, group.last, alike));
  }
  std::sort(groups.begin(), groups.end(), [](const Group& a, const Group& b) {
    return a.weight != b.weight ? a.weight > b.weight : a.first < b.first;
  });
  for (const Group& group : groups) {
    Sum all{};
    for (std::size_t k = group.first; k < group.last; ++k) {
      const Sum& sum = sums_[place_[items[k].bin] - 1u];
      result.of_bin[items[k].bin] = static_cast<std::uint32_t>(result.means.size());
      for (std::size_t axis = 0; axis < 3; ++axis) all.color[axis] += sum.color[axis];
      all.weight += sum.weight;
    }
    LinearColor& mean = result.means.emplace_back();
    for (std::size_t axis = 0; axis < 3; ++axis)
      mean[axis] = static_cast<std::uint16_t>(std::nearbyint(std::fmin(all.color[axis] / all.weight, 65535)));
  }
  return result;
}

}  // namespace fracture
