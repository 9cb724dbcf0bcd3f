// A game in which a box falls and breaks into two cubes, with a fake server in the test.
#pragma once

#include <openssl/evp.h>

#include <string>

#include "client/game/game.hpp"
#include "common/digest/digest.hpp"
#include "tests/client/cubes.hpp"
#include "tests/client/fake_server.hpp"

namespace fracture::test {

inline std::string digest_field(const std::string& bytes) {
  const Digest digest = sha256(bytes);
  unsigned char text[48];
  EVP_EncodeBlock(text, digest.bytes.data(), static_cast<int>(digest.bytes.size()));
  return "Repr-Digest: sha-256=:" + std::string(reinterpret_cast<char*>(text)) + ":\r\n";
}
inline FakeReply glb(const std::string& bytes) { return FakeReply::answer(200, bytes, digest_field(bytes)); }

/// A box of two cubes of one metre. It falls and soon hits the ground.
inline scenes::Scene falling_box() {
  scenes::Scene scene;
  scene.name = "box";
  scenes::SceneObject object;
  scenes::SurfaceMesh mesh = scenes::box({2, 1, 1});
  for (glm::vec3& p : mesh.positions) p.x += 0.5f;  // in the position of the two cubes
  object.mesh = std::make_shared<const scenes::MeshAsset>(scenes::make_asset(mesh, "box", {1, 1, 1, 1}));
  object.density = 2000;
  object.strength = 100;
  object.pose.position = {0, 1.5, 0};
  scene.objects.push_back(object);
  return scene;
}

inline protocol::Settings settings_for(const FakeServer& server) {
  protocol::Settings settings;
  settings.port = server.port();
  settings.heartbeat = protocol::Milliseconds(0);
  settings.first_pause = protocol::Milliseconds(1);
  settings.longest_pause = protocol::Milliseconds(5);
  return settings;
}

inline constexpr double kFrame = 1.0 / 60;

}  // namespace fracture::test
