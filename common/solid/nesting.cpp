#include "common/solid/nesting.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/pacer.hpp"
#include "common/solid/nesting_forest.hpp"
#include "common/solid/polled.hpp"
#include "common/solid/winding.hpp"

namespace fracture::solid_detail {
namespace {

bool inside(const Box& inner, const Box& outer) {
  for (int axis = 0; axis < 3; ++axis)
    if (inner.min[axis] < outer.min[axis] || inner.max[axis] > outer.max[axis]) return false;
  return true;
}

class Nester {
 public:
  Nester(const Surface& surface, const Shells& shells, const Execution& execution)
      : shells_(shells), windings_(surface, shells, execution), surface_(surface), execution_(execution) {
    // Largest first: the largest shells are the most likely to be outermost. Also, the orientation of every
    // enclosing shell is then known before the orientation of the shell inside.
    for (std::uint32_t i = 0; i < shells.list.size(); ++i)
      if (!shells.list[i].flat) order_.push_back(i);
    sort_with_polls(execution, order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
      const double x = std::fabs(shells.list[a].volume), y = std::fabs(shells.list[b].volume);
      return x != y ? x > y : a < b;
    });
  }

  Nesting nest() {
    const std::uint64_t enough = kWorkPerTriangle * (surface_.triangles.size() + 1024);
    if (nest_by_windings(enough)) return std::move(nesting_);
    // Deep nests: very many shells enclose each shell.
    if (const auto forest = find_nesting_forest(surface_, shells_, windings_, execution_))
      if (nest_by_forest(*forest)) return std::move(nesting_);
    nest_by_windings(~std::uint64_t{0});
    return std::move(nesting_);
  }

 private:
  static constexpr std::uint64_t kWorkPerTriangle = 64;

  void start(bool all_reversed) {
    nesting_.reversed.assign(shells_.list.size(), 0);
    nesting_.cavity_of.assign(shells_.list.size(), kNoIndex);
    if (!all_reversed) return;
    for (std::uint32_t i = 0; i < shells_.list.size(); ++i) nesting_.reversed[i] = !shells_.list[i].flat;
  }
  bool inward_in_file(std::uint32_t i) const { return shells_.list[i].volume < 0; }
  bool outward(std::uint32_t i) const { return inward_in_file(i) == (nesting_.reversed[i] != 0); }
  double volume(std::uint32_t i) const { return shells_.list[i].volume * (nesting_.reversed[i] ? -1 : 1); }
  void settle(std::uint32_t i, int winding, std::uint32_t parent) {
    if (winding >= 1 && parent != kNoIndex)
      nesting_.cavity_of[i] = parent;
    else
      nesting_.reversed[i] ^= 1;
  }

  /// Uses the list of shells that wind around each shell. Returns false if that takes more work than
  /// `enough`.
  bool nest_by_windings(std::uint64_t enough) {
    const auto any_outermost = [&](bool inwards) {
      for (const std::uint32_t i : order_)
        if (inward_in_file(i) == inwards && windings_.work() <= enough && windings_.around(i).empty())
          return true;
      return false;
    };
    start(!any_outermost(false) && any_outermost(true));
    for (const std::uint32_t i : order_) {
      if (windings_.work() > enough) return false;
      if (outward(i)) continue;
      int winding = 0;
      std::uint32_t parent = kNoIndex;
      for (const WindingNumbers::Wind& w : windings_.around(i)) {
        const int number = nesting_.reversed[w.shell] ? -w.number : w.number;
        winding += number;
        if (number > 0 && outward(w.shell) && inside(shells_.list[i].box, shells_.list[w.shell].box) &&
            (parent == kNoIndex || volume(w.shell) < volume(parent)))
          parent = w.shell;
      }
      settle(i, winding, parent);
    }
    return true;
  }

  /// Does the same with the forest, which has the winding numbers of its ancestors. Returns false if a shell
  /// is not smaller than the shell around it (if they cross themselves), because the outer shell would not be
  /// processed first.
  bool nest_by_forest(const NestingForest& forest) {
    bool outermost[2] = {false, false};  // [0]: some outermost shell is outward, [1]: some is inward
    for (const std::uint32_t i : order_) {
      if (forest.up[i] == kNoIndex)
        outermost[inward_in_file(i)] = true;
      else if (!(std::fabs(shells_.list[i].volume) < std::fabs(shells_.list[forest.up[i]].volume)))
        return false;
    }
    start(outermost[1] && !outermost[0]);
    // Per shell: the sum of the winding numbers of the shells around it, and the smallest outward shell
    // around it.
    std::vector<int> winding = filled(execution_, shells_.list.size(), 0);
    std::vector<std::uint32_t> parent = filled(execution_, shells_.list.size(), kNoIndex);
    Pacer pacer(execution_);
    for (const std::uint32_t i : order_) {
      pacer.step();
      if (const std::uint32_t up = forest.up[i]; up != kNoIndex) {
        const int number = nesting_.reversed[up] ? -forest.number[i] : forest.number[i];
        winding[i] = number + winding[up];
        parent[i] = number > 0 && outward(up) ? up : parent[up];
      }
      if (!outward(i)) settle(i, winding[i], parent[i]);
    }
    return true;
  }

  const Shells& shells_;
  WindingNumbers windings_;
  const Surface& surface_;
  const Execution& execution_;
  std::vector<std::uint32_t> order_;  ///< the shells that are not flat
  Nesting nesting_;
};

}  // namespace

Nesting nest_shells(const Surface& surface, const Shells& shells, const Execution& execution) {
  const auto count = static_cast<std::uint32_t>(shells.list.size());
  std::size_t inward = 0, usable = 0;
  for (const Shell& shell : shells.list) {
    inward += !shell.flat && shell.volume < 0;
    usable += !shell.flat;
  }
  Nesting nesting{std::vector<std::uint8_t>(count, 0), filled(execution, count, kNoIndex)};
  if (inward == 0) return nesting;
  if (usable == inward && inward == 1) {
    for (std::uint32_t i = 0; i < count; ++i) nesting.reversed[i] = !shells.list[i].flat;
    return nesting;
  }
  return Nester(surface, shells, execution).nest();
}

}  // namespace fracture::solid_detail
