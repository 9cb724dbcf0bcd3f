// A fixture for tests of reserved memory: a fake engine on one thread, 1 GiB of working memory, and no cache of meshes.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <span>
#include <string>

#include "server/service/dispatcher.hpp"
#include "tests/server/support/fake_engine.hpp"

namespace fracture::test {

/// A mesh with this number of triangles, all of whose corners are at the origin.
inline Mesh mesh_of(std::size_t triangles) {
  Mesh mesh;
  mesh.positions.resize(3 * triangles);
  mesh.triangles.resize(triangles);
  return mesh;
}

inline ServiceConfig without_mesh_cache() {
  ServiceConfig config;
  config.mesh_cache_bytes = 0;
  return config;
}

struct ReservationTest : testing::Test {
  std::shared_ptr<FakeControl> control = std::make_shared<FakeControl>();
  FractureService service{without_mesh_cache(), std::make_unique<FakeEngine>(control)};
  WorkerPool pool{1, 256};
  Dispatcher dispatcher{service, pool, {.max_working_bytes = 1u << 30}};

  FractureRequest request(std::uint64_t triangles = 0) {
    FractureRequest request;
    const auto text = std::make_shared<const std::string>("mesh");
    request.mesh = std::as_bytes(std::span(*text));
    request.owner = text;
    request.triangles = triangles;
    return request;
  }
  std::optional<Error> ask(FractureRequest asked) {
    std::optional<Error> error;
    EXPECT_FALSE(dispatcher.fracture(std::move(asked), {}, [&](Expected<FractureAnswer> answer) {
      if (!answer) error = answer.error();
    }));
    dispatcher.wait_idle();
    return error;
  }
};

}  // namespace fracture::test
