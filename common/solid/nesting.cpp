#include "common/solid/nesting.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/pacer.hpp"
#include "common/solid/winding.hpp"

namespace fracture::solid_detail {
namespace {

bool inside(const Box& inner, const Box& outer) {
  for (int axis = 0; axis < 3; ++axis)
    if (inner.min[axis] < outer.min[axis] || inner.max[axis] > outer.max[axis]) return false;
  return true;
}

}  // namespace

Nesting nest_shells(const Surface& surface, const Shells& shells, const Execution& execution) {
  const auto count = static_cast<std::uint32_t>(shells.list.size());
  Nesting nesting;
  nesting.reversed.assign(count, 0);
  nesting.cavity_of.assign(count, kNoIndex);
  std::size_t inward = 0, usable = 0;
  for (const Shell& shell : shells.list) {
    inward += !shell.flat && shell.volume < 0;
    usable += !shell.flat;
  }
  if (inward == 0) return nesting;
  if (usable == inward && inward == 1) {
    for (std::uint32_t i = 0; i < count; ++i) nesting.reversed[i] = !shells.list[i].flat;
    return nesting;
  }

  // Largest first: the largest are the likeliest to be outermost, and the orientation of whatever encloses a
  // shell is settled before the shell's own.
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < count; ++i)
    if (!shells.list[i].flat) order.push_back(i);
  sort_with_polls(execution, order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const double x = std::fabs(shells.list[a].volume), y = std::fabs(shells.list[b].volume);
    return x != y ? x > y : a < b;
  });

  WindingNumbers windings(surface, shells, execution);
  const auto any_outermost = [&](bool inwards) {
    return std::any_of(order.begin(), order.end(), [&](std::uint32_t i) {
      return (shells.list[i].volume < 0) == inwards && windings.around(i).empty();
    });
  };
  const bool all_reversed = !any_outermost(false) && any_outermost(true);
  const auto outward = [&](std::uint32_t i) {
    return (shells.list[i].volume > 0) != (nesting.reversed[i] != 0);
  };
  if (all_reversed)
    for (std::uint32_t i = 0; i < count; ++i) nesting.reversed[i] = !shells.list[i].flat;

  for (const std::uint32_t i : order) {
    if (outward(i)) continue;
    int winding = 0;
    std::uint32_t parent = kNoIndex;
    for (const WindingNumbers::Wind& w : windings.around(i)) {
      const int number = nesting.reversed[w.shell] ? -w.number : w.number;
      winding += number;
      if (number > 0 && outward(w.shell) && inside(shells.list[i].box, shells.list[w.shell].box) &&
          (parent == kNoIndex || shells.list[w.shell].volume * (nesting.reversed[w.shell] ? -1 : 1) <
                                     shells.list[parent].volume * (nesting.reversed[parent] ? -1 : 1)))
        parent = w.shell;
    }
    if (winding >= 1 && parent != kNoIndex)
      nesting.cavity_of[i] = parent;
    else
      nesting.reversed[i] ^= 1;
  }
  return nesting;
}

}  // namespace fracture::solid_detail
