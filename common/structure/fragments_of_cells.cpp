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

/// Calls visit(part, number of its cells) for each part in the fragment.
template <class Visit>
void each_part(const Fragment& f, const Visit& visit) {
  if (f.part_cells.empty()) return visit(f.part, static_cast<std::uint32_t>(f.sites.size()));
  for (std::size_t begin = 0, end = 0; begin < f.part_cells.size(); begin = end) {
    while (end < f.part_cells.size() && f.part_cells[end].part == f.part_cells[begin].part) ++end;
    visit(f.part_cells[begin].part, static_cast<std::uint32_t>(end - begin));
  }
}

template <class Visit>
void each_cell(const Fragment& f, const Visit& visit) {
  for (const PartCell& cell : f.part_cells) visit(cell);
  if (!f.part_cells.empty()) return;
  for (const SiteId s : f.sites) visit(PartCell{f.part, s});
}

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
    each_part(*fragments[k], [&](std::uint32_t part, std::uint32_t cells) {
      if (begin[part] == kNoIndex) return;
      begin[part] += cells;
      if (only_[part] != kNoIndex) several[part] = 1;
      only_[part] = k;
    });
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
    pacer.step(1 + f.sites.size() / 4);
    each_cell(f, [&](const PartCell& cell) {
      if (wanted[cell.part]) entries[begin[cell.part]++] = {cell.part, cell.site, k};
    });
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
