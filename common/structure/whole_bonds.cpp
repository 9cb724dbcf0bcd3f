#include "common/structure/whole_bonds.hpp"

#include <algorithm>
#include <tuple>

#include "common/base/pacer.hpp"
#include "common/contacts/scenery.hpp"

namespace fracture {
namespace {

/// A fragment for each part of the scenery. It has the cells of all fragments that it may touch, because a contact in one
/// place belongs to the same cell on both sides.
std::vector<Fragment> whole_parts(const Solid& solid, std::span<const Fragment* const> fragments,
                                  const Execution& execution) {
  const Scenery& around = *solid.scenery;
  Pacer pacer(execution);
  std::vector<std::vector<SiteId>> sites(solid.parts.size());  // per part in contact with the scenery
  std::vector<char> touches(solid.parts.size(), 0);
  for (const Contact& c : around.both.contacts->contacts) touches[c.a] = 1;
  const auto add = [&](std::uint32_t part, SiteId site) {
    pacer.step();
    if (touches[part]) sites[part].push_back(site);
  };
  for (const Fragment* f : fragments) {
    for (const PartCell& cell : f->part_cells) add(cell.part, cell.site);
    if (f->part_cells.empty())
      for (const SiteId s : f->sites) add(f->part, s);
  }
  std::vector<Fragment> whole(around.node_of_part.size());
  for (std::size_t k = 0; k < whole.size(); ++k)
    whole[k].part = static_cast<std::uint32_t>(solid.parts.size() + k);
  for (const Contact& c : around.both.contacts->contacts) {
    std::vector<SiteId>& here = whole[c.b - solid.parts.size()].sites;
    here.insert(here.end(), sites[c.a].begin(), sites[c.a].end());
  }
  for (Fragment& f : whole) {
    sort_with_polls(execution, f.sites.begin(), f.sites.end());
    f.sites.erase(std::unique(f.sites.begin(), f.sites.end()), f.sites.end());
  }
  return whole;
}

}  // namespace

std::vector<WholeBond> find_whole_bonds(const Solid& solid, const CellSites& cells, const Vec3d& lattice_step,
                                        double strength, std::span<const Fragment* const> fragments,
                                        std::span<const char> wanted, const Execution& execution) {
  std::vector<WholeBond> bonds;
  if (!solid.scenery || !(strength > 0)) return bonds;
  const Scenery& around = *solid.scenery;
  std::vector<Fragment> whole = whole_parts(solid, fragments, execution);
  std::vector<const Fragment*> all(fragments.begin(), fragments.end());
  std::vector<char> of_all(wanted.begin(), wanted.end());
  for (const Fragment& part : whole) all.push_back(&part);
  if (!wanted.empty()) of_all.resize(all.size(), 0);
  const CellMap map = cells.map.with_parts(around.both.parts.size());
  const ContactBonds with{around.both, {cells.points, map}, lattice_step, strength};
  Pacer pacer(execution);
  for (const Bond& bond : find_contact_bonds(with, all, of_all, execution)) {
    pacer.step();
    bonds.push_back({bond.a, around.node_of_part[bond.b - fragments.size()], bond.area, bond.centroid,
                     bond.normal, bond.strength});
  }
  std::stable_sort(bonds.begin(), bonds.end(), [](const WholeBond& x, const WholeBond& y) {
    return std::tie(x.fragment, x.node) < std::tie(y.fragment, y.node);
  });
  // Contacts with several parts of a node are one bond.
  std::size_t kept = 0;
  for (std::size_t begin = 0, end = 0; begin < bonds.size(); begin = end) {
    WholeBond sum = bonds[begin];
    Vec3d moment, normal;
    sum.area = 0;
    for (; end < bonds.size() && bonds[end].fragment == sum.fragment && bonds[end].node == sum.node; ++end) {
      sum.area += bonds[end].area;
      moment = moment + bonds[end].area * bonds[end].centroid;
      normal = normal + bonds[end].area * bonds[end].normal;
    }
    if (end - begin > 1) {
      sum.centroid = (1 / sum.area) * moment;
      if (const double l = length(normal); l > 0) sum.normal = (1 / l) * normal;
    }
    bonds[kept++] = sum;
  }
  bonds.resize(kept);
  return bonds;
}

}  // namespace fracture
