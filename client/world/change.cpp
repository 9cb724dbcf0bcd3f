#include "client/world/change.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_map>
#include <unordered_set>

namespace fracture::world {
namespace {

bool contains(const std::vector<std::uint32_t>& ascending, std::uint32_t value) {
  return std::binary_search(ascending.begin(), ascending.end(), value);
}

std::string no_such(std::uint64_t id) {
  return "The answer to a hit changes fragment " + std::to_string(id) + ", which does not exist.";
}

}  // namespace

Expected<ChangedFragments> apply_change(const FragmentSet& before, FragmentChange change) {
  ChangedFragments out{.set = before, .replaced = {}, .made = {}, .first_bond = before.bonds.size()};
  FragmentSet& set = out.set;
  std::unordered_map<std::uint64_t, std::uint32_t> number;  // used only for lookups
  for (std::uint32_t k = 0; k < set.fragments.size(); ++k) {
    if (!set.fragments[k].gone) number.emplace(set.fragments[k].id, k);
  }
  for (const auto* list : {&change.gone, &change.changed})
    for (const std::uint64_t id : *list) {
      const auto at = number.find(id);
      if (at == number.end()) return fail(ErrorCode::kMalformedMesh, no_such(id));
      out.replaced.push_back(at->second);
    }
  // Pairs of a changed fragment come from the new answer. Either of the two fragments may list the pair.
  std::unordered_set<std::uint64_t> replaced;
  for (const std::uint32_t k : out.replaced) replaced.insert(set.fragments[k].id);
  for (Fragment& fragment : set.fragments)
    std::erase_if(fragment.apart, [&](std::uint64_t id) { return replaced.contains(id); });
  for (const std::uint64_t id : change.gone) {
    const auto at = number.find(id);
    if (at == number.end()) return fail(ErrorCode::kMalformedMesh, no_such(id));  // the file lists it twice
    set.fragments[at->second].gone = true;
    number.erase(at);
  }
  for (Fragment& fragment : change.fragments) {
    const auto at = number.find(fragment.id);
    const bool changed =
        std::find(change.changed.begin(), change.changed.end(), fragment.id) != change.changed.end();
    if (changed != (at != number.end()))
      return fail(ErrorCode::kMalformedMesh, changed ? no_such(fragment.id)
                                                     : "The answer to a hit adds fragment " +
                                                           std::to_string(fragment.id) +
                                                           ", which already exists.");
    if (changed) {
      out.made.push_back(at->second);
      set.fragments[at->second] = std::move(fragment);
      continue;
    }
    if (set.fragments.size() >= kMaxFragments)
      return fail(ErrorCode::kTooLarge, "The hits made more than " + std::to_string(kMaxFragments) +
                                            " fragments, which is the game's limit.");
    const auto next = static_cast<std::uint32_t>(set.fragments.size());
    number.emplace(fragment.id, next);
    out.made.push_back(next);
    set.fragments.push_back(std::move(fragment));
  }
  std::sort(out.replaced.begin(), out.replaced.end());
  std::sort(out.made.begin(), out.made.end());
  for (Bond& bond : set.bonds)
    bond.gone = bond.gone || contains(out.replaced, bond.a) || contains(out.replaced, bond.b);
  for (std::size_t k = 0; k < change.bonds.size(); ++k) {
    const auto a = number.find(change.ends[k].a), b = number.find(change.ends[k].b);
    if (a == number.end() || b == number.end())
      return fail(ErrorCode::kMalformedMesh,
                  "A bond refers to fragment " +
                      std::to_string(a == number.end() ? change.ends[k].a : change.ends[k].b) +
                      ", which does not exist.");
    Bond bond = change.bonds[k];
    bond.a = a->second;
    bond.b = b->second;
    set.bonds.push_back(bond);
  }
  return out;
}

bool is_cracked(const ChangedFragments& changed, const FragmentSet& before, std::size_t bond,
                const std::vector<bool>& broken) {
  const Bond& now = changed.set.bonds[bond];
  const bool a_stayed = !contains(changed.made, now.a), b_stayed = !contains(changed.made, now.b);
  double least = HUGE_VAL;
  bool cracked = false;
  for (std::size_t k = 0; k < before.bonds.size(); ++k) {
    const Bond& was = before.bonds[k];
    if (was.gone || !changed.set.bonds[k].gone) continue;
    const auto has = [&](std::uint32_t end) { return was.a == end || was.b == end; };
    const bool related = a_stayed ? has(now.a) : b_stayed ? has(now.b) : has(now.a) && has(now.b);
    const double distance = glm::distance(was.center, now.center);
    if (!related || distance >= least) continue;
    least = distance;
    cracked = broken[k];
  }
  return cracked;
}

}  // namespace fracture::world
