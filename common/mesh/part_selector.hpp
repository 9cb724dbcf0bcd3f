// Names that choose parts of a scene: the selectors of `assign`, and the entries of `nodes` and `materials`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/name_pattern.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

/// Chooses parts of a solid. Each list that is not empty must have an entry that matches the part.
struct PartSelector {
  std::vector<std::string> nodes{};  ///< entries for SceneNames::mark_nodes()
  /// For SceneNames::mark_slots(). The material on most of a part's surface decides
  std::vector<std::string> slots{};
  std::vector<std::uint32_t> parts{};  ///< indices into Solid::parts
  bool empty() const { return nodes.empty() && slots.empty() && parts.empty(); }
  friend bool operator==(const PartSelector&, const PartSelector&) = default;
};

/// Maximum number of byte comparisons between patterns and the names of one mesh: about a tenth of a second.
inline constexpr std::size_t kMostNameSteps = 20'000'000;

/// The names in a mesh, and the entries that match them. An entry matches the names that are equal to it. If there is none
/// and the entry is a number, it is an index. Otherwise it is a pattern (base/name_pattern.hpp).
class SceneNames {
 public:
  /// Borrows the mesh.
  explicit SceneNames(const Mesh& mesh);

  /// Marks each node (Mesh::node_names) that the entry matches by its own name, by its index, or by the name of a group above
  /// it. Returns whether it matches any node.
  bool mark_nodes(const std::string& entry, std::vector<bool>& marked);
  /// Marks each material of the library that the entry matches by its name or index.
  bool mark_slots(const std::string& entry, std::vector<bool>& marked);

  /// The names of nodes and of the groups above them, each once, in the order of the source.
  std::vector<std::string> nodes() const;
  /// The names of materials, each once, in the order of the source.
  std::vector<std::string> slots() const;
  std::size_t node_count() const { return mesh_.node_names.size(); }
  std::size_t slot_count() const { return slots_.size(); }
  /// Whether kMostNameSteps were used up. Entries then match too little.
  bool spent() const { return budget_.spent(); }

 private:
  const Mesh& mesh_;
  std::vector<std::string> slots_;
  MatchBudget budget_{kMostNameSteps, {}};
};

}  // namespace fracture
