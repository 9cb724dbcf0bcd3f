#include "common/solid/part_selection.hpp"

#include <algorithm>

#include "common/base/nearest_name.hpp"
#include "common/base/pacer.hpp"
#include "common/base/printable.hpp"
#include "common/base/words.hpp"
#include "common/solid/main_materials.hpp"

namespace fracture {
namespace {

constexpr std::size_t kListedNames = 3;  // maximum number in a warning

std::string in_quotes(const std::string& name) { return "'" + printable(shortened(name)) + "'"; }

/// The selectors, resolved to nodes and materials of one mesh.
class Matcher {
 public:
  Matcher(const Solid& solid, const Execution& execution)
      : solid_(solid), execution_(execution), names_(*solid.source) {}

  /// Calls visit(part) for each part that the selector matches, ascending.
  template <class Visit>
  void each_part(const PartSelector& selector, const Visit& visit) {
    std::vector<bool> nodes(names_.node_count()), slots(names_.slot_count()), parts;
    for (const std::string& entry : selector.nodes) look([&] { names_.mark_nodes(entry, nodes); });
    for (const std::string& entry : selector.slots) look([&] { names_.mark_slots(entry, slots); });
    if (!selector.slots.empty() && main_.empty()) main_ = main_materials(solid_, execution_);
    parts.resize(selector.parts.empty() ? 0 : solid_.parts.size());
    for (const std::uint32_t p : selector.parts)
      if (p < parts.size()) parts[p] = true;
    Pacer pacer(execution_);
    pacer.each(0, solid_.parts.size(), [&](std::size_t p) {
      const std::uint32_t node = solid_.parts[p].node;
      const bool by_node = selector.nodes.empty() || (node < nodes.size() && nodes[node]);
      const bool by_slot = selector.slots.empty() || (main_[p] < slots.size() && slots[main_[p]]);
      const bool by_part = selector.parts.empty() || parts[p];
      if (by_node && by_slot && by_part && !selector.empty()) visit(static_cast<std::uint32_t>(p));
    });
  }

 private:
  template <class Mark>
  void look(const Mark& mark) {
    execution_.poll();
    mark();
    if (names_.spent())
      throw Interrupted(Error{ErrorCode::kTooComplex,
                              "The patterns in 'assign' need more than " + grouped(kMostNameSteps) +
                                  " comparisons with the names of this mesh. Give simpler patterns.",
                              "assign"});
  }

  const Solid& solid_;
  const Execution& execution_;
  SceneNames names_;
  std::vector<std::uint32_t> main_;
};

std::string listed(const std::vector<std::string>& entries, const std::vector<std::string>& known) {
  if (known.empty()) return " The mesh has no such names.";
  if (known.size() > kListedNames)
    return printable(did_you_mean(entries.front(), known)) +
           " `fracture-server inspect --json` and GET /meshes/{id} list the names.";
  std::string text;
  for (const std::string& name : nearest_names(entries.front(), known, kListedNames))
    text += (text.empty() ? "" : ", ") + in_quotes(name);
  return (known.size() == 1 ? " The only name is " : " The names are ") + text + ".";
}

}  // namespace

PartChoice choose_parts(const Solid& solid, const std::vector<PartSelector>& selectors,
                        const Execution& execution) {
  PartChoice choice{std::vector<std::uint32_t>(solid.parts.size(), kNoIndex),
                    std::vector<bool>(selectors.size())};
  if (selectors.empty()) return choice;
  Matcher matcher(solid, execution);
  for (std::uint32_t k = 0; k < selectors.size(); ++k)
    matcher.each_part(selectors[k], [&](std::uint32_t part) {
      choice.matches[k] = true;
      if (choice.of_part[part] == kNoIndex) choice.of_part[part] = k;
    });
  return choice;
}

std::vector<std::string> warnings_of(const Solid& solid, const std::vector<PartSelector>& selectors,
                                     const PartChoice& choice) {
  std::vector<bool> decides(selectors.size());
  for (const std::uint32_t k : choice.of_part)
    if (k != kNoIndex) decides[k] = true;
  const SceneNames names(*solid.source);
  std::vector<std::string> warnings;
  for (std::size_t k = 0; k < selectors.size(); ++k) {
    if (decides[k]) continue;
    const PartSelector& selector = selectors[k];
    std::string text = "Entry " + std::to_string(k + 1) + " of 'assign' (" + in_words(selector) + ") ";
    if (choice.matches[k]) {
      warnings.push_back(
          text +
          "has no effect, because earlier entries already cover all parts that it matches. Move it up.");
      continue;
    }
    text += "matches no part, so it has no effect.";
    if (!selector.nodes.empty()) text += listed(selector.nodes, names.nodes());
    if (!selector.slots.empty()) text += listed(selector.slots, names.slots());
    if (!selector.parts.empty())
      text +=
          " The mesh has " + counted(solid.parts.size(), "part", "parts") + "; the first has the number 0.";
    warnings.push_back(text + " Correct the entry, or leave it out.");
  }
  return warnings;
}

std::string in_words(const PartSelector& selector) {
  std::string text;
  const auto add = [&](const char* what, const std::vector<std::string>& entries) {
    if (entries.empty()) return;
    text += std::string(text.empty() ? "" : " and ") + what + " " + entries.front();
    if (entries.size() > 1) text += " or " + grouped(entries.size() - 1) + " more";
  };
  const auto names = [](std::vector<std::string> entries) {
    for (std::string& entry : entries) entry = in_quotes(entry);
    return entries;
  };
  std::vector<std::string> parts;
  for (const std::uint32_t p : selector.parts) parts.push_back(std::to_string(p));
  add("node", names(selector.nodes));
  add("slot", names(selector.slots));
  add("part", parts);
  return text;
}

}  // namespace fracture
