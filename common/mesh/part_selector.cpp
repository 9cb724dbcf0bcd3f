#include "common/mesh/part_selector.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <set>

#include "common/mesh/material_library.hpp"

namespace fracture {
namespace {

std::optional<std::size_t> index_in(const std::string& entry, std::size_t count) {
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(entry.data(), entry.data() + entry.size(), index);
  if (error != std::errc{} || end != entry.data() + entry.size() || index >= count) return std::nullopt;
  return index;
}

std::vector<std::string> each_once(std::vector<std::string> names) {
  std::set<std::string> seen;
  std::erase_if(names, [&](const std::string& name) { return name.empty() || !seen.insert(name).second; });
  return names;
}

}  // namespace

SceneNames::SceneNames(const Mesh& mesh) : mesh_(mesh) {
  for (const auto& material : mesh.library->materials) {
    const auto name = material.find("name");
    slots_.push_back(name != material.end() && name->is_string() ? name->get<std::string>() : std::string());
  }
}

bool SceneNames::mark_nodes(const std::string& entry, std::vector<bool>& marked) {
  const std::vector<std::string>& names = mesh_.node_names;
  const std::vector<NodeGroup>& groups = mesh_.groups;
  marked.resize(names.size(), false);
  const auto mark = [&](const auto& matches) {
    std::vector<bool> in_group(groups.size());
    for (std::size_t g = 0; g < groups.size(); ++g)
      in_group[g] = (groups[g].parent != kNoIndex && in_group[groups[g].parent]) || matches(groups[g].name);
    bool any = false;
    for (std::size_t k = 0; k < names.size(); ++k) {
      const std::uint32_t group = k < mesh_.group_of_node.size() ? mesh_.group_of_node[k] : kNoIndex;
      if (!(group != kNoIndex && in_group[group]) && !matches(names[k])) continue;
      marked[k] = any = true;
    }
    return any;
  };
  if (mark([&](const std::string& name) { return name == entry; })) return true;
  if (const auto index = index_in(entry, names.size())) return marked[*index] = true;
  if (is_plain(entry)) return false;
  return mark([&](const std::string& name) { return matches_pattern(entry, name, budget_); });
}

bool SceneNames::mark_slots(const std::string& entry, std::vector<bool>& marked) {
  marked.resize(slots_.size(), false);
  const auto mark = [&](const auto& matches) {
    bool any = false;
    for (std::size_t k = 0; k < slots_.size(); ++k)
      if (matches(slots_[k])) marked[k] = any = true;
    return any;
  };
  if (mark([&](const std::string& name) { return name == entry; })) return true;
  if (const auto index = index_in(entry, slots_.size())) return marked[*index] = true;
  if (is_plain(entry)) return false;
  return mark([&](const std::string& name) { return matches_pattern(entry, name, budget_); });
}

std::vector<std::string> SceneNames::nodes() const {
  std::vector<std::string> names = mesh_.node_names;
  for (const NodeGroup& group : mesh_.groups) names.push_back(group.name);
  return each_once(std::move(names));
}

std::vector<std::string> SceneNames::slots() const { return each_once(slots_); }

}  // namespace fracture
