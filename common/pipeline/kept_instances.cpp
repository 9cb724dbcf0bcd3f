#include "common/pipeline/kept_instances.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include "common/base/disjoint_sets.hpp"
#include "common/base/pacer.hpp"
#include "common/pipeline/part_sets.hpp"

namespace fracture {
namespace {

/// Equal instances differ by the rounding of their vertices, which must not decide which of them stay whole.
constexpr double kAboutTheMean = 1.01;

/// Per part: the instance that contains it if its volume is at most `most` (m³), otherwise kNoIndex.
std::vector<std::uint32_t> small_instances(const Solid& solid, double most, Pacer& pacer) {
  std::vector<std::uint32_t> small(solid.parts.size(), kNoIndex);
  const std::vector<Instance>& all = solid.instances->all;
  for (std::uint32_t k = 0; k < all.size(); ++k) {
    pacer.step(all[k].parts.size());
    if (all[k].volume > most) continue;
    for (const std::uint32_t p : all[k].parts) small[p] = k;
  }
  return small;
}

/// Unites parts in contact. Contacts of the parts in `apart` do not count; if it is empty, all count.
void unite_touching(const Solid& solid, const std::vector<std::uint32_t>& apart, DisjointSets& sets,
                    Pacer& pacer) {
  if (!solid.contacts) return;
  const auto counts = [&](std::uint32_t part) { return apart.empty() || apart[part] == kNoIndex; };
  for (const Contact& c : solid.contacts->contacts) {
    pacer.step();
    if (c.area > 0 && counts(c.a) && counts(c.b)) sets.unite(c.a, c.b);
  }
}

/// Unites the parts of each of these instances. `whole`: per part, its instance or kNoIndex.
void unite_instances(const Solid& solid, const std::vector<std::uint32_t>& whole, DisjointSets& sets,
                     Pacer& pacer) {
  pacer.each(0, whole.size(), [&](std::size_t p) {
    if (whole[p] != kNoIndex)
      sets.unite(solid.instances->all[whole[p]].parts[0], static_cast<std::uint32_t>(p));
  });
}

/// Forgets the instances that touch other parts.
void keep_lonely(const Solid& solid, DisjointSets& sets, std::vector<std::uint32_t>& whole, Pacer& pacer) {
  std::vector<std::uint32_t> members(whole.size(), 0);  // per root
  for (std::uint32_t p = 0; p < whole.size(); ++p) {
    pacer.step();
    ++members[sets.find(p)];
  }
  for (std::uint32_t p = 0; p < whole.size(); ++p) {
    pacer.step();
    if (whole[p] != kNoIndex && members[sets.find(p)] != solid.instances->all[whole[p]].parts.size())
      whole[p] = kNoIndex;
  }
}

std::vector<std::uint32_t> numbers_of(DisjointSets& sets, Pacer& pacer) {
  std::vector<std::uint32_t> group(sets.size());
  std::uint32_t next = 0;
  for (std::uint32_t p = 0; p < group.size(); ++p) {  // the lowest part of a group comes first
    pacer.step();
    group[p] = sets.find(p) == p ? next++ : group[sets.find(p)];
  }
  return group;
}

/// Returns the instances that stay whole and have all their parts among `parts` (ascending), as instances of a solid of these
/// parts; null if there are none. `kept`: PartGroups::whole of the whole.
std::shared_ptr<const Instances> kept_among(const Solid& whole, const std::vector<std::uint32_t>& kept,
                                            const std::vector<std::uint32_t>& parts, Pacer& pacer) {
  std::vector<std::uint32_t> in_set(whole.parts.size(), kNoIndex);
  for (std::uint32_t k = 0; k < parts.size(); ++k) in_set[parts[k]] = k;
  auto found = std::make_shared<Instances>();
  found->of_part.assign(parts.size(), kNoIndex);
  for (const Instance& instance : whole.instances->all) {
    pacer.step(instance.parts.size());
    const bool is_here = std::all_of(instance.parts.begin(), instance.parts.end(), [&](std::uint32_t p) {
      return kept[p] != kNoIndex && in_set[p] != kNoIndex;
    });
    if (!is_here) continue;
    Instance own = instance;
    for (std::uint32_t& p : own.parts) {
      p = in_set[p];
      found->of_part[p] = static_cast<std::uint32_t>(found->all.size());
    }
    found->all.push_back(std::move(own));
  }
  if (found->all.empty()) return nullptr;
  return found;
}

}  // namespace

std::uint32_t wanted_fragments(const FractureParameters& parameters) {
  return std::max(1u, parameters.size.fragments > 0 ? parameters.size.fragments : parameters.sites);
}

bool may_keep_instances(const Solid& solid, const FractureParameters& parameters) {
  return parameters.instances != InstanceUse::kSeparate && parameters.parts != Parts::kApart &&
         solid.instances != nullptr;
}

PartGroups group_parts(const Solid& solid, const FractureParameters& parameters, std::uint32_t wanted,
                       const Execution& execution) {
  Pacer pacer(execution);
  PartGroups groups;
  if (may_keep_instances(solid, parameters) && parameters.instances == InstanceUse::kAll) {
    groups.whole = solid.instances->of_part;
  } else if (may_keep_instances(solid, parameters)) {
    groups.whole = small_instances(solid, kAboutTheMean * solid.report.volume / std::max(wanted, 1u), pacer);
    if (parameters.parts == Parts::kTogether) {
      DisjointSets sets(solid.parts.size());
      unite_touching(solid, {}, sets, pacer);
      unite_instances(solid, groups.whole, sets, pacer);
      if (sets.set_count() <= wanted) keep_lonely(solid, sets, groups.whole, pacer);
    }
    if (std::all_of(groups.whole.begin(), groups.whole.end(), [](std::uint32_t i) { return i == kNoIndex; }))
      groups.whole.clear();
  }
  DisjointSets sets(solid.parts.size());
  if (parameters.parts == Parts::kTogether) unite_touching(solid, groups.whole, sets, pacer);
  unite_instances(solid, groups.whole, sets, pacer);
  groups.of_part = numbers_of(sets, pacer);
  return groups;
}

void keep_instances_in(std::vector<PartSet>& sets, const Solid& whole, const FractureParameters& parameters,
                       const Execution& execution) {
  if (!may_keep_instances(whole, parameters)) return;
  const std::vector<std::uint32_t> kept =
      group_parts(whole, parameters, wanted_fragments(parameters), execution).whole;
  if (kept.empty()) return;
  Pacer pacer(execution);
  for (PartSet& set : sets) {
    set.own->instances = kept_among(whole, kept, set.parts, pacer);
    if (set.own->instances) set.parameters.instances = InstanceUse::kAll;
  }
}

}  // namespace fracture
