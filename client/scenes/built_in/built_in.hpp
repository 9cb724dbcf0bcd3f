// The scenes that the game brings, a file for each, and what they share. Private to client/scenes.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>

#include "client/scenes/scene.hpp"
#include "client/scenes/solid_shapes.hpp"

namespace fracture::scenes::built_in {

Expected<Scene> monkey();
Scene panes();
Scene wall();
Scene concrete();
Scene temple();
Scene crates();
Scene shop();
Scene building();
Scene ice();

std::shared_ptr<const MeshAsset> share(MeshAsset asset);
/// A place, turned about the vertical by so many degrees.
world::Pose at(double x, double y, double z, double degrees = 0);
/// anchor_plane: what reaches below this height of its own frame is held.
nlohmann::json ground_plane(double height);

/// Hollow, 1.7 m high.
SurfaceMesh vase();

}  // namespace fracture::scenes::built_in
