#include "common/mesh/source_tree.hpp"

#include "common/base/pacer.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

std::size_t SourceNodes::size() const {
  return mesh_.source_tree ? mesh_.source_tree->nodes.size() : mesh_.node_names.size();
}

const std::string& SourceNodes::name(std::uint32_t node) const {
  return mesh_.source_tree ? mesh_.source_tree->nodes[node].name : mesh_.node_names[node];
}

std::uint32_t SourceNodes::parent(std::uint32_t node) const {
  return mesh_.source_tree ? mesh_.source_tree->nodes[node].parent : kNoIndex;
}

const std::string& SourceNodes::extras(std::uint32_t node) const {
  static const std::string kNone;
  return mesh_.source_tree ? mesh_.source_tree->nodes[node].extras : kNone;
}

std::uint32_t SourceNodes::of_instance(std::uint32_t instance) const {
  if (!mesh_.source_tree) return instance < mesh_.node_names.size() ? instance : kNoIndex;
  const std::vector<std::uint32_t>& of = mesh_.source_tree->of_instance;
  return instance < of.size() ? of[instance] : kNoIndex;
}

std::uint32_t SourceNodes::common_ancestor(const NodeRange& instances) const {
  std::uint32_t a = of_instance(instances.first), b = of_instance(instances.last);
  while (a != b && a != kNoIndex && b != kNoIndex) {
    std::uint32_t& later = a > b ? a : b;  // which is not above the other
    later = parent(later);
  }
  return a == b ? a : kNoIndex;
}

bool SourceNodes::is_hierarchy(const Execution& execution) const {
  if (size() < 2) return false;
  Pacer pacer(execution);
  std::uint32_t first = kNoIndex;
  for (const Mesh* mesh : {&mesh_, mesh_.passed_through.get()}) {
    if (mesh == nullptr) continue;
    std::uint32_t before = kNoIndex;
    for (const std::uint32_t instance : mesh->node) {
      pacer.step();
      if (instance == before) continue;
      before = instance;
      const std::uint32_t node = of_instance(instance);
      if (node == kNoIndex || node == first) continue;
      if (first != kNoIndex) return true;
      first = node;
    }
  }
  return first != kNoIndex && parent(first) != kNoIndex;
}

}  // namespace fracture
