#include "common/gltf/khr_physics.hpp"

#include "common/gltf/body_frame.hpp"
#include "common/physics/principal_axes.hpp"

namespace fracture {
namespace {

constexpr const char* kName = "KHR_physics_rigid_bodies";

/// Index of the fragment's filter; kNoIndex if it collides with all others.
std::uint32_t filter_of(const SceneLayout& layout, std::size_t fragment) {
  const CollisionFilters* const filters = layout.filters();
  return filters != nullptr && !filters->of_body.empty() ? filters->of_body[fragment] : kNoIndex;
}

/// Index of the physics material of a part.
std::uint32_t surface_of(const GltfOptions& options, std::size_t part) {
  return part < options.surface_of_part.size() ? options.surface_of_part[part] : 0;
}

void write_surface(JsonText& json, double friction, double restitution) {
  json.begin_object().member("staticFriction", friction).member("dynamicFriction", friction);
  json.member("restitution", restitution).end_object();
}

void write_collider(JsonText& json, std::size_t mesh, std::uint32_t surface, std::uint32_t filter) {
  json.key("collider").begin_object().key("geometry").begin_object();
  json.member("mesh", mesh).member("convexHull", true).end_object();
  json.member("physicsMaterial", surface);
  if (filter != kNoIndex) json.member("collisionFilter", filter);
  json.end_object();
}

void write_filter(JsonText& json, const CollisionFilters::Filter& filter) {
  json.begin_object().key("collisionSystems").begin_array().value(std::to_string(filter.system)).end_array();
  if (!filter.excluded.empty()) {
    json.key("notCollideWithSystems").begin_array();
    for (const std::uint32_t system : filter.excluded) json.value(std::to_string(system));
    json.end_array();
  }
  json.end_object();
}

void write_collider(JsonText& json, const Fragment& f, std::size_t fragment, std::size_t hull,
                    const SceneLayout& layout, const GltfOptions& options) {
  write_collider(json, layout.hull_mesh(fragment, hull), surface_of(options, f.source_part),
                 filter_of(layout, fragment));
}

}  // namespace

void write_khr_physics_document(JsonText& json, const SceneLayout& layout, const GltfOptions& options) {
  json.key(kName).begin_object().key("physicsMaterials").begin_array();
  write_surface(json, options.friction, options.restitution);
  for (const ContactSurface& surface : options.surfaces)
    write_surface(json, surface.friction, surface.restitution);
  json.end_array();
  if (const CollisionFilters* const filters = layout.filters(); filters && !filters->filters.empty()) {
    json.key("collisionFilters").begin_array();
    for (const CollisionFilters::Filter& filter : filters->filters) write_filter(json, filter);
    json.end_array();
  }
  json.end_object();
}

void write_khr_physics_body(JsonText& json, const Fragment& f, std::size_t index, const SceneLayout& layout,
                            const GltfOptions& options) {
  const PrincipalAxes axes = body_inertia(f);
  const double density = options.density * f.density_share;
  const InstancedBodies::Body* const instance = layout.instance(index);
  // Instances are many, and engines store floats.
  const auto put = [&](double number) { instance == nullptr ? json.value(number) : json.rounded(number); };
  json.key(kName).begin_object().key("motion").begin_object();
  json.key("mass");
  put(body_volume(f) * density);
  json.key("centerOfMass");
  write_center_of_mass(json, f, instance);
  json.key("inertiaDiagonal").begin_array();
  for (const double moment : axes.moments) put(moment * density);
  json.end_array().key("inertiaOrientation").begin_array();
  for (const double component : principal_rotation(axes, instance)) put(component);
  json.end_array().end_object();
  if (layout.hulls(index) == 1) write_collider(json, f, index, 0, layout, options);
  json.end_object();
}

void write_khr_physics_collider(JsonText& json, const Fragment& f, std::size_t fragment, std::size_t hull,
                                const SceneLayout& layout, const GltfOptions& options) {
  json.key(kName).begin_object();
  write_collider(json, f, fragment, hull, layout, options);
  json.end_object();
}

void write_khr_physics_static_collider(JsonText& json, const Fragment& f, std::size_t mesh,
                                       const GltfOptions& options) {
  json.key(kName).begin_object();
  write_collider(json, mesh, surface_of(options, f.source_part), kNoIndex);
  json.end_object();
}

}  // namespace fracture
