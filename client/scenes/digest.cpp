#include "common/digest/digest.hpp"
#include "client/scenes/scene.hpp"
#include "common/base/json_text.hpp"

namespace fracture::scenes {
namespace {

using nlohmann::json;

json text_of(const world::Pose& pose) {
  const glm::dvec3& p = pose.position;
  const glm::dquat& q = pose.rotation;
  return {p.x, p.y, p.z, q.x, q.y, q.z, q.w};
}

}  // namespace

std::string digest_of(const Scene& scene) {
  json all = {scene.ball_radius, scene.ball_density};
  for (const SceneObject& object : scene.objects) {
    const Breakage& breakage = object.breakage;
    all.push_back({sha256(std::string_view(object.mesh->bytes)).hex(), object.mesh->unit,
                   text_of(object.pose), object.held, object.density, object.strength, object.reach,
                   object.crack_front, object.friction, object.restitution, object.at_start});
    all.push_back({breakage.parameters, breakage.impacts, breakage.radius, breakage.sites, breakage.reach,
                   breakage.energy});
  }
  for (const SceneBox& box : scene.boxes)
    all.push_back({text_of(box.pose), box.half_sides.x, box.half_sides.y, box.half_sides.z});
  return sha256(std::string_view(json_text(all))).hex();
}

}  // namespace fracture::scenes
