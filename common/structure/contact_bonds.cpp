#include "common/structure/contact_bonds.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/base/work_blocks.hpp"
#include "common/structure/contact_sharer.hpp"

namespace fracture {
namespace {

/// A sum of normals that is a smaller share of the area is noise.
constexpr double kCancelledNormals = 1e-9;

bool is_before(const Bond& x, const Bond& y) { return std::tie(x.a, x.b) < std::tie(y.a, y.b); }

/// Adds up the bonds of two fragments by shared caps and by contacts.
Bond sum_of(const Bond& caps, const Bond& contacts) {
  Bond sum = caps.area >= contacts.area ? caps : contacts;  // its normal stays if the normals cancel
  sum.area = caps.area + contacts.area;
  sum.centroid = (1 / sum.area) * (caps.area * caps.centroid + contacts.area * contacts.centroid);
  const Vec3d normal = caps.area * caps.normal + contacts.area * contacts.normal;
  if (const double l = length(normal); l > kCancelledNormals * sum.area) sum.normal = (1 / l) * normal;
  sum.strength = (caps.area * caps.strength + contacts.area * contacts.strength) / sum.area;
  return sum;
}

/// Adds up the bonds of each two fragments that are in contact through several pairs of parts. `bonds` are
/// in the order of their contacts; the result is ascending.
std::vector<Bond> one_for_each_pair(std::vector<Bond> bonds, const Execution& execution) {
  std::vector<std::uint32_t> order(bonds.size());
  std::iota(order.begin(), order.end(), 0u);
  sort_with_polls(execution, order.begin(), order.end(), [&](std::uint32_t x, std::uint32_t y) {
    return std::tie(bonds[x].a, bonds[x].b, x) < std::tie(bonds[y].a, bonds[y].b, y);
  });
  Pacer pacer(execution);
  std::vector<Bond> sums;
  sums.reserve(bonds.size());
  for (std::size_t k = 0, end = 0; k < order.size(); k = end) {
    const Bond& first = bonds[order[k]];
    Bond sum = first;
    Vec3d moment, normal;
    sum.area = 0;
    for (end = k; end < order.size() && !is_before(first, bonds[order[end]]); ++end) {
      pacer.step();
      const Bond& bond = bonds[order[end]];
      sum.area += bond.area;
      moment = moment + bond.area * bond.centroid;
      normal = normal + bond.area * bond.normal;
    }
    if (end - k > 1) {
      sum.centroid = (1 / sum.area) * moment;
      if (const double l = length(normal); l > kCancelledNormals * sum.area) sum.normal = (1 / l) * normal;
    } else {
      sum.area = first.area;
    }
    sums.push_back(sum);
  }
  return sums;
}

void want_parts_of(const Fragment& f, std::vector<char>& wanted) {
  wanted[f.part] = 1;
  for (const PartCell& cell : f.part_cells) wanted[cell.part] = 1;
}

}  // namespace

bool parts_hold_together(const Solid& solid) {
  if (!solid.contacts) return false;
  const std::vector<Contact>& contacts = solid.contacts->contacts;
  return std::any_of(contacts.begin(), contacts.end(), [](const Contact& c) { return c.area > 0; });
}

std::vector<Bond> find_contact_bonds(const ContactBonds& with, std::span<const Fragment* const> fragments,
                                     std::span<const char> wanted, const Execution& execution) {
  if (!(with.strength > 0) || !parts_hold_together(with.solid)) return {};
  const Allowance::Temporary temporary(execution.allowance);  // frees everything except the bonds
  const ContactGraph& graph = *with.solid.contacts;
  const FragmentsOfCells table(with.solid, fragments, execution);
  bool has_many = false;
  for (std::uint32_t p = 0; p < with.solid.parts.size(); ++p)
    has_many |= table.of(p).size() > CellDivision::kMany;
  execution.poll();
  const CellDivision division(table, with.cells.points, has_many);

  std::vector<char> wanted_parts;
  if (!wanted.empty()) {
    wanted_parts.resize(with.solid.parts.size(), 0);
    for (std::size_t k = 0; k < fragments.size(); ++k)
      if (wanted[k]) want_parts_of(*fragments[k], wanted_parts);
  }

  constexpr std::uint64_t kWorkOfPiece = 500, kWorkOfContact = 100, kMostWork = 4'000'000;  // ns
  const WorkBlocks blocks(execution, graph.contacts.size(), kMostWork, [&](std::size_t k) {
    return kWorkOfContact + kWorkOfPiece * (graph.first_piece[k + 1] - graph.first_piece[k]);
  });
  std::vector<std::vector<Bond>> found(blocks.count());
  parallel_for_blocks(execution, blocks, [&](std::size_t block, std::size_t begin, std::size_t end) {
    ContactSharer sharer(with, table, division, fragments, wanted, wanted_parts, execution);
    for (std::size_t k = begin; k < end; ++k) sharer.share(static_cast<std::uint32_t>(k), found[block]);
    execution.made(Product::kContacts, found[block].size());
  });
  std::size_t count = 0;
  for (const auto& of_block : found) count += of_block.size();
  std::vector<Bond> bonds;
  bonds.reserve(count);
  for (const auto& of_block : found) {
    execution.poll();
    bonds.insert(bonds.end(), of_block.begin(), of_block.end());
  }
  return one_for_each_pair(std::move(bonds), execution);
}

void add_contact_bonds(FragmentSet& set, const Solid& solid, const CellSites& cells, double strength,
                       const Execution& execution) {
  if (!(strength > 0) || !parts_hold_together(solid)) return;
  Pacer pacer(execution);
  std::vector<const Fragment*> fragments;
  fragments.reserve(set.fragments.size());
  for (const Fragment& f : set.fragments) {
    pacer.step();
    fragments.push_back(&f);
  }
  const std::vector<Bond> more =
      find_contact_bonds({solid, cells, set.lattice_step, strength}, fragments, {}, execution);
  execution.made(Product::kContacts, more.size());
  set.bonds = with_contact_bonds(set.bonds, more, execution);
}

std::vector<Bond> with_contact_bonds(std::span<const Bond> caps, std::span<const Bond> contacts,
                                     const Execution& execution) {
  Pacer pacer(execution);
  std::vector<Bond> all;
  all.reserve(caps.size() + contacts.size());
  auto cap = caps.begin();
  for (const Bond& contact : contacts) {
    for (; cap != caps.end() && is_before(*cap, contact); ++cap) {
      pacer.step();
      all.push_back(*cap);
    }
    pacer.step();
    const bool is_both = cap != caps.end() && !is_before(contact, *cap);
    all.push_back(is_both ? sum_of(*cap++, contact) : contact);
  }
  execution.poll();
  all.insert(all.end(), cap, caps.end());
  return all;
}

}  // namespace fracture
