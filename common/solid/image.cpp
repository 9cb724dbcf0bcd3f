#include "common/solid/image.hpp"

#include "common/solid/layers.hpp"
#include "common/solid/polled.hpp"

namespace fracture {

Solid image_of(const Solid& solid, const CellMap& map, const Execution& execution) {
  using solid_detail::copied, solid_detail::for_each_polled;
  // Each vertex belongs to one part.
  std::vector<std::uint32_t> part_of_vertex;
  if (map.frames().size() > 1) {
    part_of_vertex = solid_detail::filled<std::uint32_t>(execution, solid.positions.size(), 0);
    for_each_polled(execution, solid.triangles.size(), [&](std::size_t t) {
      for (const VertexId v : solid.triangles[t]) part_of_vertex[v] = solid.part[t];
    });
  }
  Solid image;
  image.triangles = copied(execution, solid.triangles);
  image.edges = copied(execution, solid.edges);
  image.edge_vertices = copied(execution, solid.edge_vertices);
  image.shell = copied(execution, solid.shell);
  image.part = copied(execution, solid.part);
  image.parts = copied(execution, solid.parts);
  image.positions.reserve(solid.positions.size());
  for_each_polled(execution, solid.positions.size(), [&](std::size_t v) {
    const CellMap::Frame& frame = map.of_part(part_of_vertex.empty() ? 0 : part_of_vertex[v]);
    const Vec3d q = frame.image(to_double(solid.positions[v]));
    image.positions.push_back({static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z)});
    image.box.add(to_double(image.positions.back()));
  });
  const double factor = map.of_part(0).matrix.determinant();  // the determinant is the same in all frames
  for (Part& part : image.parts) {
    part.volume *= factor;
    part.box = {};
  }
  for_each_polled(execution, image.triangles.size(), [&](std::size_t t) {
    Vec3d corner[3];
    for (int k = 0; k < 3; ++k) {
      corner[k] = to_double(image.positions[image.triangles[t][k]]);
      image.parts[image.part[t]].box.add(corner[k]);
    }
    image.report.area += 0.5 * length(cross(corner[1] - corner[0], corner[2] - corner[0]));
  });
  image.report.volume = solid.report.volume * factor;
  // Boxes that were disjoint may overlap in the image.
  image.layers = solid_detail::assign_layers(image.parts, execution);
  return image;
}

}  // namespace fracture
