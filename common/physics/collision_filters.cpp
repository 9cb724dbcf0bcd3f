#include "common/physics/collision_filters.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "common/base/id.hpp"
#include "common/base/pacer.hpp"

namespace fracture {
namespace {

/// Classes of bodies with the same partners, numbered in the order of their first body. kNoIndex: no partner.
struct Twins {
  std::vector<std::uint32_t> of_body;
  std::uint32_t count = 0;
};

Twins find_twins(std::size_t bodies, std::span<const BodyPair> pairs, Pacer& pacer) {
  std::vector<std::vector<std::uint32_t>> partners(bodies);
  for (const BodyPair& pair : pairs) {  // ascending, so the partners of each body are, too
    pacer.step(4);
    partners[pair.b].push_back(pair.a);
  }
  for (const BodyPair& pair : pairs) partners[pair.a].push_back(pair.b);
  std::map<std::vector<std::uint32_t>, std::uint32_t> class_of;
  Twins twins;
  twins.of_body.assign(bodies, kNoIndex);
  for (std::size_t k = 0; k < bodies; ++k) {
    if (partners[k].empty()) continue;
    pacer.step(16 + partners[k].size());
    const auto [at, is_new] = class_of.emplace(std::move(partners[k]), twins.count);
    if (is_new) ++twins.count;
    twins.of_body[k] = at->second;
  }
  return twins;
}

/// Whether each class gets a named system. Each round names the class with the most pairs not covered yet.
std::vector<char> name_classes(const Twins& twins, std::span<const BodyPair> pairs, std::uint32_t most,
                               Pacer& pacer) {
  std::vector<char> named(twins.count, 0);
  std::vector<std::uint32_t> open(twins.count);
  for (std::uint32_t round = 0; round < most; ++round) {
    open.assign(twins.count, 0);
    for (const BodyPair& pair : pairs) {
      pacer.step();
      const std::uint32_t a = twins.of_body[pair.a], b = twins.of_body[pair.b];
      if (named[a] || named[b]) continue;
      ++open[a];
      ++open[b];
    }
    const auto best = std::max_element(open.begin(), open.end());  // the first of equals
    if (best == open.end() || *best == 0) break;
    named[static_cast<std::size_t>(best - open.begin())] = 1;
  }
  return named;
}

}  // namespace

CollisionFilters make_collision_filters(std::size_t bodies, std::span<const BodyPair> pairs,
                                        const Execution& execution) {
  CollisionFilters result;
  if (pairs.empty()) return result;
  Pacer pacer(execution);
  const Twins twins = find_twins(bodies, pairs, pacer);
  const std::vector<char> named = name_classes(twins, pairs, kMostCollisionSystems - 1, pacer);
  std::vector<std::uint32_t> system_of_class(twins.count, kNoIndex);
  result.systems = 1;
  for (std::uint32_t c = 0; c < twins.count; ++c)
    if (named[c]) system_of_class[c] = result.systems++;

  std::vector<std::vector<std::uint32_t>> excluded(bodies);
  std::vector<char> concerned(bodies, 0);
  for (const BodyPair& pair : pairs) {
    pacer.step(4);
    const std::uint32_t a = system_of_class[twins.of_body[pair.a]],
                        b = system_of_class[twins.of_body[pair.b]];
    if (a == kNoIndex && b == kNoIndex) {
      result.beyond.push_back(pair);
      continue;
    }
    concerned[pair.a] = concerned[pair.b] = 1;
    if (a != kNoIndex) excluded[pair.b].push_back(a);
    if (b != kNoIndex) excluded[pair.a].push_back(b);
  }
  std::map<std::pair<std::uint32_t, std::vector<std::uint32_t>>, std::uint32_t> numbers;
  result.of_body.assign(bodies, kNoIndex);
  for (std::size_t k = 0; k < bodies; ++k) {
    if (!concerned[k]) continue;
    pacer.step(16 + excluded[k].size());
    std::sort(excluded[k].begin(), excluded[k].end());
    excluded[k].erase(std::unique(excluded[k].begin(), excluded[k].end()), excluded[k].end());
    const std::uint32_t own = system_of_class[twins.of_body[k]];
    CollisionFilters::Filter filter{own == kNoIndex ? 0 : own, std::move(excluded[k])};
    const auto [at, is_new] = numbers.emplace(std::pair(filter.system, filter.excluded),
                                              static_cast<std::uint32_t>(result.filters.size()));
    if (is_new) result.filters.push_back(std::move(filter));
    result.of_body[k] = at->second;
  }
  return result;
}

}  // namespace fracture
