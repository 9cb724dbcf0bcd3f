#include "common/gltf/khr_physics.hpp"

#include "common/physics/principal_axes.hpp"

namespace fracture {
namespace {

constexpr const char* kName = "KHR_physics_rigid_bodies";

void write_collider(JsonText& json, std::size_t mesh, std::uint32_t system) {
  json.key("collider").begin_object().key("geometry").begin_object();
  json.member("mesh", mesh).member("convexHull", true).end_object();
  json.member("physicsMaterial", 0);
  if (system != kNoIndex) json.member("collisionFilter", system);
  json.end_object();
}

void write_collider(JsonText& json, std::size_t fragment, std::size_t hull, const SceneLayout& layout) {
  write_collider(json, layout.hull_mesh(fragment, hull), layout.systems().of_fragment[fragment]);
}

}  // namespace

void write_khr_physics_document(JsonText& json, const SceneLayout& layout, const GltfOptions& options) {
  json.key(kName).begin_object().key("physicsMaterials").begin_array().begin_object();
  json.member("staticFriction", options.friction).member("dynamicFriction", options.friction);
  json.member("restitution", options.restitution).end_object().end_array();
  if (const std::size_t systems = layout.systems().count; systems > 0) {
    json.key("collisionFilters").begin_array();
    for (std::size_t k = 0; k < systems; ++k) {
      const std::string name = std::to_string(k);
      json.begin_object().key("collisionSystems").begin_array().value(name).end_array();
      json.key("notCollideWithSystems").begin_array().value(name).end_array().end_object();
    }
    json.end_array();
  }
  json.end_object();
}

void write_khr_physics_body(JsonText& json, const Fragment& f, std::size_t index, const SceneLayout& layout,
                            const GltfOptions& options) {
  const PrincipalAxes axes = body_inertia(f);
  const double density = options.density * f.density_share;
  json.key(kName).begin_object().key("motion").begin_object();
  json.member("mass", body_volume(f) * density);
  json.member("centerOfMass", f.mass.center_of_mass - f.pivot);
  json.key("inertiaDiagonal").begin_array();
  for (const double moment : axes.moments) json.value(moment * density);
  json.end_array().key("inertiaOrientation").begin_array();
  for (const double component : axes.rotation) json.value(component);
  json.end_array().end_object();
  if (layout.hulls(index) == 1) write_collider(json, index, 0, layout);
  json.end_object();
}

void write_khr_physics_collider(JsonText& json, std::size_t fragment, std::size_t hull,
                                const SceneLayout& layout) {
  json.key(kName).begin_object();
  write_collider(json, fragment, hull, layout);
  json.end_object();
}

void write_khr_physics_static_collider(JsonText& json, std::size_t mesh) {
  json.key(kName).begin_object();
  write_collider(json, mesh, kNoIndex);
  json.end_object();
}

}  // namespace fracture
