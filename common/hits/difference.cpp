#include "common/hits/difference.hpp"

#include <algorithm>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/pipeline/make_report.hpp"

namespace fracture {

bool same_shape(const Fragment& a, const Fragment& b) {
  const auto same_primitive = [](const FragmentPrimitive& x, const FragmentPrimitive& y) {
    return x.material == y.material && x.first_index == y.first_index && x.index_count == y.index_count &&
           x.part == y.part;
  };
  return a.pivot == b.pivot && a.mass.volume == b.mass.volume && a.mass.area == b.mass.area &&
         a.mass.center_of_mass == b.mass.center_of_mass && a.mass.inertia == b.mass.inertia &&
         a.exterior_area == b.exterior_area && a.sites == b.sites && a.positions == b.positions &&
         a.indices == b.indices && a.topology == b.topology &&
         std::equal(a.primitives.begin(), a.primitives.end(), b.primitives.begin(), b.primitives.end(),
                    same_primitive) &&
         a.attributes.normals == b.attributes.normals && a.attributes.tangents == b.attributes.tangents &&
         a.attributes.uvs == b.attributes.uvs && a.attributes.colors == b.attributes.colors;
}

bool same_sheet(const Fragment* a, const Fragment* b) {
  return a == b || (a != nullptr && b != nullptr && same_shape(*a, *b));
}

bool same_hulls(const FragmentHulls& a, const FragmentHulls& b) {
  return std::equal(a.hulls.begin(), a.hulls.end(), b.hulls.begin(), b.hulls.end(),
                    [](const CollisionHull& x, const CollisionHull& y) {
                      return x.points == y.points && x.triangles == y.triangles;
                    });
}

Delta difference(const FracturedBase& before, const FracturedSolid& after, const Execution& execution) {
  Pacer pacer(execution);
  const std::vector<SharedFragment>& earlier = before.broken.fragments;
  std::unordered_map<std::uint64_t, std::uint32_t> place;  // only looked up
  place.reserve(earlier.size());
  for (std::uint32_t k = 0; k < earlier.size(); ++k) {
    pacer.step(16);
    place.emplace(earlier[k]->fragment.id, k);
  }
  std::vector<char> still(earlier.size(), 0);
  Delta delta;
  static const FragmentHulls kNoHulls;
  const std::vector<FragmentHulls>& all_hulls = after.hulls.of_fragment;
  for (std::size_t k = 0; k < after.set.fragments.size(); ++k) {
    const Fragment& f = after.set.fragments[k];
    const FragmentHulls& hulls = all_hulls.empty() ? kNoHulls : all_hulls[k];
    pacer.step(16);
    const auto at = place.find(f.id);
    if (at == place.end()) {
      delta.added.push_back(f.id);
      continue;
    }
    still[at->second] = 1;
    const KeptFragment& was = *earlier[at->second];
    const FragmentHulls& had = before.stated_hulls.empty() ? was.hulls : before.stated_hulls[at->second];
    if (!same_shape(was.fragment, f) || !same_hulls(had, hulls) ||
        !same_sheet(was.fragment.sheet.get(), f.sheet.get()))
      delta.changed.push_back(f.id);
  }
  for (std::uint32_t k = 0; k < still.size(); ++k)
    if (!still[k]) delta.gone.push_back(earlier[k]->fragment.id);
  clear_nodes(pacer, place);
  return delta;
}

void point_upwards(std::vector<Bond>& bonds, const Execution& execution) {
  for (Bond& b : bonds) {
    if (b.a < b.b) continue;
    std::swap(b.a, b.b);
    for (int axis = 0; axis < 3; ++axis) b.normal[axis] = b.normal[axis] == 0 ? 0 : -b.normal[axis];
  }
  sort_with_polls(execution, bonds.begin(), bonds.end(),
                  [](const Bond& x, const Bond& y) { return std::tie(x.a, x.b) < std::tie(y.a, y.b); });
}

void keep_rest_of(Rest& rest, const std::vector<std::uint32_t>& fragments, const Delta& delta) {
  std::vector<std::uint64_t> concerned = delta.added;
  concerned.insert(concerned.end(), delta.changed.begin(), delta.changed.end());
  std::sort(concerned.begin(), concerned.end());
  const auto is_concerned = [&](std::uint64_t id) {
    return std::binary_search(concerned.begin(), concerned.end(), id);
  };
  std::erase_if(rest.filtered,
                [&](const auto& pair) { return !is_concerned(pair[0]) && !is_concerned(pair[1]); });
  std::vector<std::uint32_t>& of_body = rest.filters.of_body;
  if (of_body.empty()) return;
  for (std::size_t k = 0; k < fragments.size(); ++k) of_body[k] = of_body[fragments[k]];
  of_body.resize(fragments.size());
}

void keep_changed(FracturedSolid& fractured, const Execution& execution) {
  Pacer pacer(execution);
  FragmentSet& set = fractured.set;
  Delta& delta = fractured.delta.value();
  std::vector<FragmentHulls>& all_hulls = fractured.hulls.of_fragment;
  std::vector<char>& all_held = fractured.anchored.held;
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
  if (fractured.rest) {
    std::vector<std::uint32_t> fragments;
    for (std::uint32_t k = 0; k < n; ++k)
      if (index[k] != kNoIndex) fragments.push_back(k);
    keep_rest_of(*fractured.rest, fragments, delta);
  }
  // Removed fragments at the other end of a bond are numbered in the order of the whole.
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
  }
  point_upwards(set.bonds, execution);
  std::erase_if(fractured.whole_bonds, [&](const WholeBond& b) { return index[b.fragment] >= kept; });
  for (WholeBond& b : fractured.whole_bonds) b.fragment = index[b.fragment];
  std::vector<Fragment> fragments(kept);
  std::vector<FragmentHulls> hulls(all_hulls.empty() ? 0 : kept);
  std::vector<char> held(all_held.empty() ? 0 : kept);
  std::vector<std::uint32_t>& all_bodies = fractured.instances.of_fragment;
  std::vector<std::uint32_t> bodies(all_bodies.empty() ? 0 : kept);
  for (std::size_t k = 0; k < n; ++k) {
    pacer.step(4);
    if (index[k] >= kept) {
      set.fragments[k] = {};  // destroying thousands of them takes a while
      if (!all_hulls.empty()) all_hulls[k] = {};
      continue;
    }
    fragments[index[k]] = std::move(set.fragments[k]);
    if (!all_hulls.empty()) hulls[index[k]] = std::move(all_hulls[k]);
    if (!all_held.empty()) held[index[k]] = all_held[k];
    if (!all_bodies.empty()) bodies[index[k]] = all_bodies[k];
  }
  set.fragments = std::move(fragments);
  all_hulls = std::move(hulls);
  all_held = std::move(held);
  all_bodies = std::move(bodies);
  fractured.anchored.count = static_cast<std::uint32_t>(std::count(all_held.begin(), all_held.end(), 1));
  fractured.report.anchored.reset();
  std::erase(fractured.report.remarks.warnings, kNothingAnchored);
}

}  // namespace fracture
