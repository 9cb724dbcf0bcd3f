#include "common/fragment/fragment_mesh.hpp"

#include "common/base/pacer.hpp"
#include "common/mesh/material_library.hpp"

namespace fracture {

Mesh fragment_mesh(const FragmentSet& set, std::size_t index, const Execution& execution) {
  Pacer pacer(execution);
  const Fragment& f = set.fragments.at(index);
  Mesh mesh;
  mesh.positions.reserve(f.positions.size());
  for (const Vec3f& local : f.positions) {
    pacer.step();
    const Vec3d p = to_double(local) + f.pivot;
    mesh.positions.push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
  }
  mesh.frame = set.source->frame;
  execution.poll();
  mesh.attributes = f.attributes;
  execution.poll();
  mesh.triangles.reserve(f.indices.size() / 3);
  mesh.material.reserve(f.indices.size() / 3);
  for (const FragmentPrimitive& primitive : f.primitives)
    for (std::uint32_t k = 0; k < primitive.index_count; k += 3) {
      pacer.step();
      const std::uint32_t* corner = f.indices.data() + primitive.first_index + k;
      mesh.triangles.push_back({corner[0], corner[1], corner[2]});
      mesh.material.push_back(primitive.material);
    }
  mesh.node.assign(mesh.triangles.size(), f.node);
  mesh.node_names = set.source->node_names;
  mesh.node_extras = set.source->node_extras;
  mesh.groups = set.source->groups;
  mesh.group_of_node = set.source->group_of_node;
  mesh.source_tree = set.source->source_tree;
  mesh.library = set.source->library;
  mesh.copyright = set.source->copyright;
  mesh.dropped = set.source->dropped;
  return mesh;
}

}  // namespace fracture
