#include "common/solid/image.hpp"

#include "common/solid/layers.hpp"

namespace fracture {

Solid image_of(const Solid& solid, const Matrix3& map) {
  Solid image;
  image.triangles = solid.triangles;
  image.edges = solid.edges;
  image.edge_vertices = solid.edge_vertices;
  image.shell = solid.shell;
  image.part = solid.part;
  image.parts = solid.parts;
  image.positions.reserve(solid.positions.size());
  for (const Vec3f& p : solid.positions) {
    const Vec3d q = map * to_double(p);
    image.positions.push_back({static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z)});
    image.box.add(to_double(image.positions.back()));
  }
  const double factor = map.determinant();
  for (Part& part : image.parts) {
    part.volume *= factor;
    part.box = {};
  }
  for (std::size_t t = 0; t < image.triangles.size(); ++t) {
    Vec3d corner[3];
    for (int k = 0; k < 3; ++k) {
      corner[k] = to_double(image.positions[image.triangles[t][k]]);
      image.parts[image.part[t]].box.add(corner[k]);
    }
    image.report.area += 0.5 * length(cross(corner[1] - corner[0], corner[2] - corner[0]));
  }
  image.report.volume = solid.report.volume * factor;
  // Disjoint boxes may have images whose boxes meet.
  image.layers = solid_detail::assign_layers(image.parts);
  return image;
}

}  // namespace fracture
