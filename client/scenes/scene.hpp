// A scene to play in: what stands where, how it breaks, and what a run without a player throws.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "client/render/looks.hpp"
#include "client/scenes/mesh_asset.hpp"

namespace fracture::scenes {

/// What the request for fragments says, and how it grows with the energy of the hit.
struct Breakage {
  nlohmann::json parameters = nlohmann::json::object();  ///< of every request: material, anchors, …
  bool impacts = false;                                  ///< its pattern takes `impacts`: where it was hit
  bool radius = false;                                   ///< … and `radius`
  int sites = 60;       ///< at `energy`; both counts and radius grow with its cube root
  double reach = 0.5;   ///< metres: `radius` at `energy`
  double energy = 500;  ///< J
};

struct SceneObject {
  std::string name;
  std::shared_ptr<const MeshAsset> mesh;
  world::Pose pose;
  bool held = false;
  double density = 1000;                  ///< kg/m³
  double strength = 100;                  ///< N·s
  double reach = 0.5, crack_front = 0.4;  ///< as in world::ObjectSpec
  double friction = 0.6, restitution = 0.1;
  Breakage breakage;
  bool at_start = false;  ///< its fragments are asked for when the level is loaded, not when it is hit
  render::SolidLook look = render::SolidLook::kNone;
  glm::vec3 grain{0, 1, 0};
  float look_scale = 1;  ///< of the look's solid texture
  glm::vec2 bricks{0};   ///< courses of bricks of this size are drawn from the mesh's lower corner; 0: none
};

struct SceneBox {  ///< does not move
  world::Pose pose;
  glm::dvec3 half_sides{0.5};
  render::SolidLook look = render::SolidLook::kConcrete;
};

struct Throw {
  double time = 0;  ///< seconds
  glm::dvec3 from{0}, velocity{0};
};

/// What may be thrown instead of the scene's ball. 0: as the scene's.
struct Ball {
  double radius = 0;   ///< metres
  double density = 0;  ///< kg/m³
};
/// Three tonnes, at the pace of a crane's.
inline constexpr Ball kWreckingBall{0.45, 7800};
inline constexpr double kWreckingSpeed = 7;  ///< m/s
/// Breaks the monkey (2.6 t) from 1.6 m away, and pushes it from 3 m.
inline constexpr double kBlastImpulse = 8e4;  ///< N·s
inline constexpr double kBlastRadius = 6;     ///< metres

struct TimedBlast {
  double time = 0;  ///< seconds
  world::Blast blast;
};

/// From where, and at what, in metres.
struct View {
  glm::vec3 eye{0}, target{0};
};

/// The view comes closer by itself, as in a film, until a player takes it.
struct CameraMove {
  double from = 0, until = 1;  ///< seconds
  View to;
};

struct Scene {
  std::string name, title;
  std::vector<SceneObject> objects;
  std::vector<SceneBox> boxes;
  std::vector<Throw> throws;
  std::vector<TimedBlast> blasts;  ///< in the order of their times
  double ball_radius = 0.12, ball_density = 7800, ball_speed = 16;
  glm::vec3 eye{0, 2, 8}, target{0, 1, 0};
  std::optional<CameraMove> closer;
  render::Sphere bounds{{0, 1, 0}, 5};  ///< what light and shadows cover
  std::vector<std::string> warnings;
};

/// At a time of the game in seconds.
View view_at(const Scene& scene, double seconds);

/// In the order of the menu.
std::vector<std::string> scene_names();

/// A built-in scene; kBadParameter with the names there are. Meshes are generated; the monkey is read from
/// assimp-testmodels, and is a vase where that is not installed.
Expected<Scene> make_scene(const std::string& name);

/// The meshes of files, and of folders all that can be read (at most 40), in rows above the ground, the low ones in
/// front. `unit`: as for load_asset. A file that cannot be read is a warning; kEmptyMesh where none can.
Expected<Scene> scene_of_files(const std::vector<std::string>& paths, const std::string& unit = {});

/// Of all that decides how the scene moves and breaks, as 64 hexadecimal digits: meshes, places, materials. Equal digests,
/// equal beginnings. What is thrown, and what is only seen, is not in it.
std::string digest_of(const Scene& scene);

/// Materials for the number keys 1 … 8, in the server's order.
const std::vector<std::string>& material_names();

/// Gives an object, or every one, another material: parameters, density, look, and a strength in proportion.
void set_material(SceneObject& object, const std::string& material);
void set_material(Scene& scene, const std::string& material);

/// The query of PUT /meshes/… for an object's mesh: its material, which may make walls of it.
std::string preparation_query(const SceneObject& object);

/// The body of POST /meshes/…/fracture for a hit. `overrides` (from the panel) replace whatever they name.
nlohmann::json fracture_parameters(const SceneObject& object, const world::Impact& impact, std::uint64_t seed,
                                   const nlohmann::json& overrides);

/// A further hit on what is fractured already: finer fragments near a place.
struct LocalHit {
  glm::dvec3 point{0};  ///< in the asset's frame
  double radius = 0;    ///< metres
  int sites = 0;
};
/// As the request for fragments it grows with the energy; at `Breakage::energy` it has half of its sites within half of its
/// reach.
LocalHit local_hit(const SceneObject& object, const world::Impact& impact);
/// Can an answer to these parameters be hit again, and the client put together what that changes? Not where they divide it
/// into levels, or give its cuts maps that such an answer leaves out; and one answer takes at most 64 hits.
bool takes_hits(const nlohmann::json& parameters);
/// The body of the request beside the answer's address.
nlohmann::json hit_parameters(const std::string& of, const LocalHit& hit);
/// The parameters of an answer with one more hit: what the same request is without an address.
nlohmann::json with_hit(nlohmann::json parameters, const LocalHit& hit);

}  // namespace fracture::scenes
