#include "common/gltf/empty_nodes.hpp"

#include "common/gltf/unique_names.hpp"

namespace fracture {

EmptyNodes::EmptyNodes(const FragmentSet& set, const SceneLayout& layout, const std::vector<WholeNode>& whole,
                       std::size_t first_node, const Execution& execution)
    : set_(set), first_node_(first_node) {
  if (set.fragments.empty() || set.source->empty_nodes.empty()) return;
  UniqueNames names(layout, set.fragments.size(), execution);
  for (const WholeNode& node : whole) names.take(node.name);
  for (const EmptyNode& node : set.source->empty_nodes) names_.push_back(names.add(node.name));
}

void EmptyNodes::write(JsonText& json) const {
  for (std::size_t k = 0; k < names_.size(); ++k) {
    const EmptyNode& node = set_.source->empty_nodes[k];
    json.begin_object().member("name", names_[k]);
    const EmptyNode unmoved;
    if (!(node.x == unmoved.x && node.y == unmoved.y && node.z == unmoved.z)) {
      json.key("matrix").begin_array();  // column by column
      for (const Vec3d& column : {node.x, node.y, node.z})
        json.value(column.x).value(column.y).value(column.z).value(0.0);
      json.value(node.t.x).value(node.t.y).value(node.t.z).value(1.0).end_array();
    } else if (!(node.t == unmoved.t)) {
      json.member("translation", node.t);
    }
    if (!node.extras.empty()) json.key("extras").begin_object().value_text(node.extras).end_object();
    json.end_object();
  }
}

}  // namespace fracture
