#include "client/scenes/built_in/built_in.hpp"

namespace fracture::scenes::built_in {

std::shared_ptr<const MeshAsset> share(MeshAsset asset) {
  return std::make_shared<const MeshAsset>(std::move(asset));
}

world::Pose at(double x, double y, double z, double degrees) {
  return {{x, y, z}, glm::angleAxis(glm::radians(degrees), glm::dvec3(0, 1, 0))};
}

nlohmann::json ground_plane(double height) {
  using nlohmann::json;
  return json::array({json::array({0, height, 0}), json::array({0, 1, 0})});
}

SurfaceMesh vase() {
  Turned shape;
  shape.segments = 48;
  // Outside from the foot upwards, over the rim, and down inside.
  shape.profile = {{0.30f, 0.0f},  {0.34f, 0.03f}, {0.30f, 0.10f}, {0.48f, 0.40f}, {0.58f, 0.75f},
                   {0.52f, 1.05f}, {0.30f, 1.35f}, {0.24f, 1.50f}, {0.30f, 1.66f}, {0.36f, 1.70f},
                   {0.30f, 1.68f}, {0.18f, 1.50f}, {0.24f, 1.33f}, {0.46f, 1.04f}, {0.51f, 0.75f},
                   {0.42f, 0.42f}, {0.24f, 0.14f}};
  return turned(shape);
}

}  // namespace fracture::scenes::built_in
