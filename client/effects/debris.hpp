// Dust, crumbs and marks: what a break leaves besides fragments. They are particles without physics: they
// fly, stop at the ground and disappear, without touching or moving anything. Equal seeds and histories give
// equal particles. No OpenGL.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "client/world/world.hpp"

namespace fracture::effects {

struct Crumb {
  glm::vec3 position{0}, velocity{0};
  glm::vec3 axis{0, 1, 0};   ///< axis of rotation, unit length
  float turn = 0, spin = 0;  ///< radians, radians per second
  float size = 0.01f;        ///< half the length, metres; shrinks at the end
  float stretch = 1;         ///< length over width, for splinters
  glm::vec3 color{0.5f};     ///< linear
  float age = 0, life = 1;   ///< seconds
};

struct Puff {
  glm::vec3 position{0}, velocity{0};
  float radius = 0.05f, growth = 0.3f;  ///< metres; metres per second at the start
  float turn = 0;                       ///< radians
  std::uint32_t shape = 0;              ///< 0 … 3
  glm::vec3 color{0.5f};
  float density = 0.3f;  ///< opacity at the centre, at the start
  float age = 0, life = 1;
  float opacity() const;  ///< current opacity
};

/// The trace of a hit, on the ground or on an object.
struct Mark {
  bool on_object = false;
  world::ObjectId object = 0;  ///< if on_object: position and normal are in its asset's frame …
  std::uint32_t fragment = 0;  ///< … and move with this fragment
  glm::vec3 position{0}, normal{0, 1, 0};
  float radius = 0.1f;
  float turn = 0;
  glm::vec3 color{0.5f};
  float opacity = 0.5f;
  bool cracks = false;  ///< whether it shows radial cracks
};

class Debris {
 public:
  using MaterialOf = std::function<std::string(world::ObjectId)>;

  explicit Debris(std::uint64_t seed = 1) : seed_(seed) {}

  /// Adds the particles of this step of the world, which takes `step_length` seconds, and moves all
  /// particles. `world` gives the positions of marks.
  void follow(const world::World& world, const world::Witnessed& witnessed, const MaterialOf& material_of);

  /// Moves all particles without adding any. To draw between two steps, call it on a copy.
  void move(float seconds);

  const std::vector<Crumb>& crumbs() const { return crumbs_; }
  const std::vector<Puff>& puffs() const { return puffs_; }
  const std::vector<Mark>& marks() const { return marks_; }

  // If there are more, the oldest are removed.
  static constexpr std::size_t kMostCrumbs = 3000, kMostPuffs = 320, kMostMarks = 96;

 private:
  void crack(const world::Crack& crack, const std::string& material);
  void knock(const world::World& world, const world::Knock& knock, const MaterialOf& material_of);
  void mark(const world::World& world, const world::Knock& knock, const world::Knock::Side& side,
            const std::string& material, const std::string& other);
  float random();  ///< 0 … 1
  glm::vec3 random_direction();
  /// A random count with this mean.
  std::size_t random_count(double mean);

  std::uint64_t seed_, drawn_ = 0, step_ = 0;
  std::vector<Crumb> crumbs_;  // oldest first, as in the other two lists
  std::vector<Puff> puffs_;
  std::vector<Mark> marks_;
};

}  // namespace fracture::effects
