#include "common/structure/fragments_of_cells.hpp"

#include <compare>

#include "common/base/pacer.hpp"

namespace fracture {
namespace {

struct Entry {
  std::uint32_t part;
  SiteId site;
  std::uint32_t fragment;
  auto operator<=>(const Entry&) const = default;
};

}  // namespace

FragmentsOfCells::FragmentsOfCells(const Solid& solid, std::span<const Fragment* const> fragments,
                                   const Execution& execution)
    : part_begin_(solid.parts.size() + 1, 0), only_(solid.parts.size(), kNoIndex) {
  Pacer pacer(execution);
  std::vector<std::uint32_t> begin(solid.parts.size() + 1, kNoIndex);  // kNoIndex: not needed
  for (const Contact& c : solid.contacts->contacts) {
    pacer.step();
    if (c.area > 0) begin[c.a] = begin[c.b] = 0;
  }
  std::vector<char> several(solid.parts.size(), 0);
  for (std::uint32_t k = 0; k < fragments.size(); ++k) {
    pacer.step();
    const Fragment& f = *fragments[k];
    if (begin[f.part] == kNoIndex) continue;
    begin[f.part] += static_cast<std::uint32_t>(f.sites.size());
    if (only_[f.part] != kNoIndex) several[f.part] = 1;
    only_[f.part] = k;
  }
  std::uint32_t sum = 0;
  std::vector<char> wanted(solid.parts.size(), 0);
  for (std::size_t p = 0; p < solid.parts.size(); ++p) {
    pacer.step();
    if (several[p]) only_[p] = kNoIndex;
    wanted[p] = begin[p] != kNoIndex ? 1 : 0;
    const std::uint32_t count = wanted[p] ? begin[p] : 0;
    begin[p] = sum;
    sum += count;
  }
  std::vector<Entry> entries(sum);
  for (std::uint32_t k = 0; k < fragments.size(); ++k) {
    const Fragment& f = *fragments[k];
    if (!wanted[f.part]) continue;
    pacer.step(1 + f.sites.size() / 4);
    for (const SiteId s : f.sites) entries[begin[f.part]++] = {f.part, s, k};
  }
  if (!std::is_sorted(entries.begin(), entries.end()))
    sort_with_polls(execution, entries.begin(), entries.end());
  sites_.reserve(sum);
  fragment_begin_.reserve(sum + 1);
  fragments_.reserve(sum);
  for (std::size_t k = 0; k < entries.size(); ++k) {
    pacer.step();
    const Entry& e = entries[k];
    if (k == 0 || e.part != entries[k - 1].part || e.site != entries[k - 1].site) {
      sites_.push_back(e.site);
      fragment_begin_.push_back(static_cast<std::uint32_t>(fragments_.size()));
      ++part_begin_[e.part + 1];
    }
    fragments_.push_back(e.fragment);
  }
  fragment_begin_.push_back(static_cast<std::uint32_t>(fragments_.size()));
  for (std::size_t p = 1; p < part_begin_.size(); ++p) part_begin_[p] += part_begin_[p - 1];
}

}  // namespace fracture
