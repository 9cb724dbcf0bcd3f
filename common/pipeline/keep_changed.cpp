#include "common/pipeline/keep_changed.hpp"

#include <algorithm>
#include <vector>

#include "common/base/pacer.hpp"

namespace fracture {

void keep_changed(FragmentSet& set, Delta& delta, const Execution& execution) {
  Pacer pacer(execution);
  std::vector<std::uint64_t> wanted = delta.added;
  wanted.insert(wanted.end(), delta.changed.begin(), delta.changed.end());
  sort_with_polls(execution, wanted.begin(), wanted.end());
  const std::size_t n = set.fragments.size();
  std::vector<std::uint32_t> index(n, kNoIndex);
  std::uint32_t next = 0;
  for (std::size_t k = 0; k < n; ++k) {
    pacer.step(4);
    if (std::binary_search(wanted.begin(), wanted.end(), set.fragments[k].id)) index[k] = next++;
  }
  const std::uint32_t kept = next;
  // Who is not here any more, but at the other end of a bond: numbered in the order of the whole.
  std::erase_if(set.bonds, [&](const Bond& b) { return index[b.a] == kNoIndex && index[b.b] == kNoIndex; });
  std::vector<char> met(n, 0);
  for (const Bond& b : set.bonds) met[b.a] = met[b.b] = 1;
  for (std::size_t k = 0; k < n; ++k)
    if (met[k] && index[k] == kNoIndex) {
      index[k] = next++;
      delta.neighbors.push_back(set.fragments[k].id);
    }
  for (Bond& b : set.bonds) {
    pacer.step();
    b.a = index[b.a];
    b.b = index[b.b];
    if (b.a < b.b) continue;
    std::swap(b.a, b.b);
    for (int axis = 0; axis < 3; ++axis) b.normal[axis] = b.normal[axis] == 0 ? 0 : -b.normal[axis];
  }
  sort_with_polls(execution, set.bonds.begin(), set.bonds.end(),
                  [](const Bond& x, const Bond& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; });
  std::vector<Fragment> fragments(kept);
  for (std::size_t k = 0; k < n; ++k) {
    pacer.step(4);
    if (index[k] < kept)
      fragments[index[k]] = std::move(set.fragments[k]);
    else
      set.fragments[k] = {};  // thousands of them take a while to go
  }
  set.fragments = std::move(fragments);
}

}  // namespace fracture
