#include "common/pipeline/overlaps.hpp"

#include <algorithm>
#include <vector>

#include "common/base/disjoint_sets.hpp"
#include "common/base/pacer.hpp"

namespace fracture {
namespace {

double share_of(const Fragment& f, const std::vector<double>& of_part) {
  if (f.part_volumes.empty()) return of_part[f.part];
  double all = 0, once = 0;
  for (const PartVolume& v : f.part_volumes) {
    all += v.volume;
    once += of_part[v.part] * v.volume;
  }
  return all > 0 && once > 0 ? once / all : 1;
}

double sum_of(const std::vector<double>& shares, const Solid& solid) {
  double sum = 0;
  for (std::size_t p = 0; p < shares.size(); ++p) sum += shares[p] * solid.parts[p].volume;
  return sum;
}

}  // namespace

std::vector<double> density_shares(const Solid& solid, const Execution& execution) {
  if (!solid.contacts) return {};
  Pacer pacer(execution);
  struct Group {
    double volume = 0, common = 0,
           largest = 0;  ///< m³: of all parts, of the overlaps, and of the largest part
  };
  DisjointSets sets(solid.parts.size());
  bool any = false;
  for (const Contact& c : solid.contacts->contacts) {
    pacer.step();
    if (!(c.volume > 0)) continue;
    sets.unite(c.a, c.b);
    any = true;
  }
  if (!any) return {};
  std::vector<Group> groups(solid.parts.size());  // each at the index of its lowest part
  for (std::uint32_t p = 0; p < groups.size(); ++p) {
    pacer.step();
    Group& group = groups[sets.find(p)];
    group.volume += solid.parts[p].volume;
    group.largest = std::max(group.largest, solid.parts[p].volume);
  }
  for (const Contact& c : solid.contacts->contacts)
    if (c.volume > 0) groups[sets.find(c.a)].common += c.volume;
  std::vector<double> shares(groups.size());
  for (std::uint32_t p = 0; p < shares.size(); ++p) {
    pacer.step();
    const Group& group = groups[sets.find(p)];
    shares[p] = std::max(group.volume - group.common, group.largest) / group.volume;
  }
  return shares;
}

double volume_once(const Solid& solid, const Execution& execution) {
  const std::vector<double> of_part = density_shares(solid, execution);
  return of_part.empty() ? solid.report.volume : sum_of(of_part, solid);
}

void count_overlaps_once(const Solid& solid, bool together, FragmentSet& set, const Execution& execution) {
  set.certificate.volume_once = set.certificate.volume_in;
  if (!together) return;
  Pacer pacer(execution);
  const std::vector<double> of_part = density_shares(solid, execution);
  if (of_part.empty()) return;
  set.certificate.volume_once = sum_of(of_part, solid);
  for (Fragment& f : set.fragments) {
    pacer.step();
    f.density_share = share_of(f, of_part);
  }
}

}  // namespace fracture
