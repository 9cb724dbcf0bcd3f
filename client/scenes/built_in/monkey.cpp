#include "client/scenes/built_in/built_in.hpp"

namespace fracture::scenes::built_in {

Expected<Scene> monkey() {
  Scene scene;
  scene.title = "The monkey falls to the ground";
  SceneObject object;
  const std::string path = monkey_path();
  if (path.empty()) {
    scene.warnings.push_back("assimp-testmodels is not installed, so a vase replaces the monkey.");
    object.mesh = share(make_asset(vase(), "vase", {0.3f, 0.45f, 0.6f, 1}));
  } else {
    Expected<MeshAsset> loaded = load_asset(path);
    if (!loaded) return tl::unexpected(loaded.error());
    object.mesh = share(std::move(*loaded));
  }
  object.name = object.mesh->name;
  object.pose = {{0, 2.6 - object.mesh->low.y, 0},
                 glm::angleAxis(glm::radians(12.0), glm::normalize(glm::dvec3(1, 0.3, 0.4)))};
  scene.objects.push_back(std::move(object));
  set_material(scene, "ceramic");
  scene.eye = {2.6f, 2.1f, 5.6f};
  scene.target = {0, 1.75f, 0};
  // The view first shows the whole fall, then moves closer to the result.
  scene.closer = {0.2, 0.9, {{1.4f, 1.25f, 3.7f}, {0.1f, 0.5f, 0}}};
  scene.bounds = {{0, 1.8f, 0}, 5.5f};
  scene.throws = {{3.2, {5, 2.2, 6}, {-11.5, 0.5, -13}}};
  return scene;
}

}  // namespace fracture::scenes::built_in
