// A scene to play in: its objects and their positions, how they break, and what a run without a player
// throws.
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

/// The parameters of a request for fragments, and how they grow with the energy of the hit.
struct Breakage {
  nlohmann::json parameters = nlohmann::json::object();  ///< for every request: material, anchors, …
  bool impacts = false;                                  ///< its pattern takes `impacts` (positions) …
  bool radius = false;                                   ///< … and `radius`
  int sites = 60;       ///< at `energy`; grows with its cube root, as does the radius
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
  bool at_start = false;  ///< fragments are requested when the level is loaded, not when it is hit
  render::SolidLook look = render::SolidLook::kNone;
  glm::vec3 grain{0, 1, 0};
  float look_scale = 1;  ///< scale of the look's solid texture
  glm::vec2 bricks{0};   ///< size of the bricks drawn in courses from the mesh's lower corner; 0: none
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

/// A ball to throw instead of the scene's. 0: as in the scene.
struct Ball {
  double radius = 0;   ///< metres
  double density = 0;  ///< kg/m³
};
/// Three tonnes, as fast as a crane swings it.
inline constexpr Ball kWreckingBall{0.45, 7800};
inline constexpr double kWreckingSpeed = 7;  ///< m/s
/// Breaks the monkey (2.6 t) from 1.6 m away, and only pushes it from 3 m.
inline constexpr double kBlastImpulse = 8e4;  ///< N·s
inline constexpr double kBlastRadius = 6;     ///< metres

struct TimedBlast {
  double time = 0;  ///< seconds
  world::Blast blast;
};

/// Positions of the eye and of the point it looks at, in metres.
struct View {
  glm::vec3 eye{0}, target{0};
};

/// The camera moves closer by itself, as in a film, until the player takes it over.
struct CameraMove {
  double from = 0, until = 1;  ///< seconds
  View to;
};

struct Scene {
  std::string name, title;
  std::vector<SceneObject> objects;
  std::vector<SceneBox> boxes;
  std::vector<Throw> throws;
  std::vector<TimedBlast> blasts;  ///< in time order
  double ball_radius = 0.12, ball_density = 7800, ball_speed = 16;
  glm::vec3 eye{0, 2, 8}, target{0, 1, 0};
  std::optional<CameraMove> closer;
  render::Sphere bounds{{0, 1, 0}, 5};  ///< region covered by light and shadows
  std::vector<std::string> warnings;
};

/// The view at this time of the game in seconds.
View view_at(const Scene& scene, double seconds);

/// In menu order.
std::vector<std::string> scene_names();

/// A built-in scene; kBadParameter lists the names. Meshes are generated, except for the monkey, which is
/// read from assimp-testmodels. If that is not installed, a vase replaces it.
Expected<Scene> make_scene(const std::string& name);

/// A scene of these files and of all readable files in these folders (at most 40), in rows above the ground,
/// with low objects in front. `unit`: as for load_asset. An unreadable file gives a warning. Returns kEmptyMesh
/// if no file is readable.
Expected<Scene> scene_of_files(const std::vector<std::string>& paths, const std::string& unit = {});

/// A digest, as 64 hexadecimal digits, of everything that decides how the scene moves and breaks: meshes,
/// poses and materials. Equal digests mean equal starts. It does not cover throws or appearance.
std::string digest_of(const Scene& scene);

/// Materials for the number keys 1 … 8, in the server's order.
const std::vector<std::string>& material_names();

/// Gives an object, or all objects, another material: parameters, density, look, and a strength to match.
void set_material(SceneObject& object, const std::string& material);
void set_material(Scene& scene, const std::string& material);

/// The query of PUT /meshes/… for an object's mesh: its material, and the materials of its parts (`assign` in `overrides`), which may
/// make it hollow. If they are very long, they are left out, and the server prepares the mesh again for the first request.
std::string preparation_query(const SceneObject& object, const nlohmann::json& overrides);

/// The body of POST /meshes/…/fracture for a hit. `overrides` (from the panel) replace the parameters that
/// they contain.
nlohmann::json fracture_parameters(const SceneObject& object, const world::Impact& impact, std::uint64_t seed,
                                   const nlohmann::json& overrides);

/// A further hit on a fractured object, which asks for finer fragments near a point.
struct LocalHit {
  glm::dvec3 point{0};  ///< in the asset's frame
  double radius = 0;    ///< metres
  int sites = 0;
};
/// Grows with the energy, like the request for fragments. At `Breakage::energy`, it has half as many sites
/// within half the reach.
LocalHit local_hit(const SceneObject& object, const world::Impact& impact);
/// Whether an answer to these parameters can be hit again, and the client can apply the changes. False with
/// levels, or with maps for cut faces, which a change omits. An answer takes at most 64 hits.
bool takes_hits(const nlohmann::json& parameters);
/// The body of the request, together with the answer's address.
nlohmann::json hit_parameters(const std::string& of, const LocalHit& hit);
/// The parameters of an answer with one more hit: the same request without an address.
nlohmann::json with_hit(nlohmann::json parameters, const LocalHit& hit);

}  // namespace fracture::scenes
