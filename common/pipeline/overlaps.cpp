#include "common/pipeline/overlaps.hpp"

#include <algorithm>
#include <vector>

#include "common/base/pacer.hpp"

namespace fracture {
namespace {

constexpr double kLeastShare = 0.1;

/// Returns each part's share of its density; empty if no parts overlap.
std::vector<double> density_shares(const Solid& solid, Pacer& pacer) {
  if (!solid.contacts) return {};
  std::vector<double> common;  // m³, half of the volume that each part shares with others
  for (const Contact& c : solid.contacts->contacts) {
    pacer.step();
    if (!(c.volume > 0)) continue;
    common.resize(solid.parts.size(), 0);
    common[c.a] += c.volume / 2;
    common[c.b] += c.volume / 2;
  }
  for (std::size_t p = 0; p < common.size(); ++p)
    common[p] = std::max(kLeastShare, 1 - common[p] / solid.parts[p].volume);
  return common;
}

double share_of(const Fragment& f, const std::vector<double>& of_part) {
  if (f.part_volumes.empty()) return of_part[f.part];
  double all = 0, once = 0;
  for (const PartVolume& v : f.part_volumes) {
    all += v.volume;
    once += of_part[v.part] * v.volume;
  }
  return all > 0 && once > 0 ? std::min(1.0, once / all) : 1;
}

}  // namespace

void count_overlaps_once(const Solid& solid, bool together, FragmentSet& set, const Execution& execution) {
  set.certificate.volume_once = set.certificate.volume_in;
  if (!together) return;
  Pacer pacer(execution);
  const std::vector<double> of_part = density_shares(solid, pacer);
  if (of_part.empty()) return;
  set.certificate.volume_once = 0;
  for (std::size_t p = 0; p < of_part.size(); ++p)
    set.certificate.volume_once += of_part[p] * solid.parts[p].volume;
  for (Fragment& f : set.fragments) {
    pacer.step();
    f.density_share = share_of(f, of_part);
  }
}

}  // namespace fracture
