// The built-in scenes, one file each, and their shared parts. Private to client/scenes.
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
/// A pose at this position, turned about the vertical by this many degrees.
world::Pose at(double x, double y, double z, double degrees = 0);
/// anchor_plane: anchors everything below this height in the object's own frame.
nlohmann::json ground_plane(double height);

/// A hollow vase, 1.7 m high.
SurfaceMesh vase();

}  // namespace fracture::scenes::built_in
