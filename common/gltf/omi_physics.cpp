#include "common/gltf/omi_physics.hpp"

#include "common/gltf/body_frame.hpp"
#include "common/physics/principal_axes.hpp"

namespace fracture {
namespace {

void write_collider(JsonText& json, std::size_t shape) {
  json.key("collider").begin_object().member("shape", shape).end_object();
}

}  // namespace

void write_omi_physics_document(JsonText& json, const SceneLayout& layout, const IntactScene& intact) {
  if (!layout.has_hulls()) return;
  json.key("OMI_physics_shape").begin_object().key("shapes").begin_array();
  const auto write_shape = [&](std::size_t mesh) {
    json.begin_object().member("type", "convex").key("convex").begin_object();
    json.member("mesh", mesh).end_object().end_object();
  };
  for (std::size_t hull = 0; hull < layout.hull_count(); ++hull) write_shape(layout.first_hull_mesh() + hull);
  for (std::size_t hull = 0; hull < intact.hull_count(); ++hull) write_shape(intact.first_hull_mesh() + hull);
  json.end_array().end_object();
}

void write_omi_physics_body(JsonText& json, const Fragment& f, std::size_t index, const SceneLayout& layout,
                            const GltfOptions& options) {
  json.key("OMI_physics_body").begin_object().key("motion").begin_object().member("type", "dynamic");
  json.member("mass", body_volume(f) * options.density * f.density_share);
  json.key("centerOfMass");
  write_center_of_mass(json, f, layout.instance(index));
  json.end_object();
  if (layout.hulls(index) == 1) write_collider(json, layout.hull_number(index, 0));
  json.end_object();
}

void write_omi_physics_collider(JsonText& json, std::size_t shape) {
  json.key("OMI_physics_body").begin_object();
  write_collider(json, shape);
  json.end_object();
}

}  // namespace fracture
