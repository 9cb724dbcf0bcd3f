#include "client/render/fragment_views.hpp"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <map>

#include "common/base/random.hpp"

namespace fracture::render {
namespace {

/// A reproducible random number in [0, 1) for a fragment.
float random01(std::uint64_t id, std::uint64_t which) {
  return static_cast<float>(mix64(id * 256 + which + kGoldenGamma) >> 40) / 16777216.f;
}

glm::vec3 random_direction(std::uint64_t id, std::uint64_t which) {
  const float y = 2 * random01(id, which) - 1, angle = 2 * glm::pi<float>() * random01(id, which + 1);
  const float r = std::sqrt(1 - y * y);
  return {r * std::cos(angle), y, r * std::sin(angle)};
}

glm::vec3 centroid_of(const Object& object) {
  return object.fragment ? object.fragment->centroid
                         : glm::vec3(object.transform * glm::vec4(object.bounds.center, 1));
}

std::uint64_t id_of(const Model& model, std::size_t object) {
  const auto& fragment = model.objects[object].fragment;
  return fragment ? fragment->id : object;
}

/// The group of an object at a level: a node of the hierarchy, or the object itself if it has none.
std::uint32_t group_of(const Model& model, std::size_t object, int level) {
  const auto& fragment = model.objects[object].fragment;
  if (!fragment) return kNoSlot - static_cast<std::uint32_t>(object);
  const auto& ancestors = fragment->ancestors;
  return ancestors[std::min(static_cast<std::size_t>(std::max(level, 0)), ancestors.size() - 1)];
}

/// Groups numbered in the order of their first object, with their centres (weighted by volume).
struct Groups {
  std::vector<std::uint32_t> of_object;
  std::vector<glm::vec3> centers;
};

Groups groups(const Model& model, int level) {
  Groups result;
  std::map<std::uint32_t, std::uint32_t> numbers;
  std::vector<float> weights;
  for (std::size_t k = 0; k < model.objects.size(); ++k) {
    const auto number =
        numbers.try_emplace(group_of(model, k, level), static_cast<std::uint32_t>(numbers.size()))
            .first->second;
    result.of_object.push_back(number);
    result.centers.resize(numbers.size(), glm::vec3(0));
    weights.resize(numbers.size(), 0);
    const auto& fragment = model.objects[k].fragment;
    const float weight = fragment && fragment->volume > 0 ? static_cast<float>(fragment->volume) : 1e-30f;
    result.centers[number] += weight * centroid_of(model.objects[k]);
    weights[number] += weight;
  }
  for (std::size_t g = 0; g < weights.size(); ++g) result.centers[g] /= weights[g];
  return result;
}

void explode(const Model& model, const ViewOptions& options, const Sphere& sphere,
             std::vector<ObjectState>& states) {
  const Groups of_level = options.by_group ? groups(model, options.level) : Groups{};
  for (std::size_t k = 0; k < states.size(); ++k) {
    const glm::vec3 from =
        options.by_group ? of_level.centers[of_level.of_object[k]] : centroid_of(model.objects[k]);
    const glm::vec3 shift = options.explode * (from - sphere.center);
    states[k].transform = glm::translate(glm::mat4(1), shift) * states[k].transform;
  }
}

/// A snapshot of a burst: straight flight with gravity, stopped by the ground. Lengths are relative to the
/// object's radius, so that a cup and a house behave alike.
void throw_fragments(const Model& model, const ViewOptions& options, const CameraPlacement& placement,
                     const Sphere& sphere, std::vector<ObjectState>& states) {
  const glm::vec3 to_camera = direction_to_camera(placement);
  const glm::vec3 point = options.impact_point.value_or(
      first_hit(model, sphere.center + 3 * sphere.radius * to_camera, -to_camera)
          .value_or(sphere.center + 0.5f * sphere.radius * to_camera));
  const glm::vec3 given = options.impact_direction;
  const glm::vec3 direction = glm::dot(given, given) > 0 ? glm::normalize(given) : -to_camera;
  const float reach = options.impact_radius.value_or(0.55f * sphere.radius);
  const glm::vec3 inside =
      point + 0.6f * reach * direction;  // pieces burst away from here: sideways, and back towards the impact
  float ground = HUGE_VALF;
  for (const Vertex& v : model.vertices)
    ground = std::min(ground, (model.objects[v.object].transform * glm::vec4(v.position, 1)).y);

  for (std::size_t k = 0; k < states.size(); ++k) {
    const Object& object = model.objects[k];
    const glm::vec3 centroid = centroid_of(object);
    const float distance = glm::distance(centroid, point);
    if (distance >= reach || model.objects.size() == 1) continue;
    const std::uint64_t id = id_of(model, k);
    const float force =
        options.impact_strength * std::pow(1 - distance / reach, 0.7f) * (0.6f + 0.8f * random01(id, 0));
    const glm::vec3 from_inside = centroid - inside;
    const glm::vec3 away = glm::length(from_inside) > 0 ? glm::normalize(from_inside) : -direction;
    const float time = 0.8f + 0.4f * random01(id, 1);
    const glm::vec3 velocity = force * (away + 0.35f * random_direction(id, 2));
    glm::vec3 shift = sphere.radius *
                      (0.75f * time * velocity - glm::vec3(0, 0.55f * std::min(force, 1.f) * time * time, 0));
    const float rest = ground + 0.45f * object.bounds.radius;
    shift.y = std::max(shift.y, std::min(0.f, rest - centroid.y));
    const glm::mat4 turn =
        glm::rotate(glm::mat4(1), 2.2f * force * (0.4f + random01(id, 6)), random_direction(id, 4));
    states[k].transform = glm::translate(glm::mat4(1), centroid + shift) * turn *
                          glm::translate(glm::mat4(1), -centroid) * states[k].transform;
  }
}

}  // namespace

glm::vec3 distinct_color(std::uint32_t number) {
  const float turn = 0.61803398875f * static_cast<float>(number % 4096);
  const float hue = 6 * (turn - std::floor(turn));
  const float saturation = number % 3 == 1 ? 0.50f : 0.72f, value = number % 2 == 0 ? 0.82f : 0.62f;
  glm::vec3 rgb;
  for (int c = 0; c < 3; ++c) {
    const float h = std::fmod(hue + (c == 0 ? 5.f : c == 1 ? 3.f : 1.f), 6.f);
    rgb[c] = value - value * saturation * std::clamp(std::min(h, 4 - h), 0.f, 1.f);
  }
  return rgb * rgb;  // from roughly perceived brightness to linear light
}

std::optional<glm::vec3> first_hit(const Model& model, const glm::vec3& origin, const glm::vec3& direction) {
  float nearest = HUGE_VALF;
  std::vector<glm::vec3> p(3);
  for (std::size_t i = 0; i + 2 < model.indices.size(); i += 3) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vertex& v = model.vertices[model.indices[i + k]];
      p[k] = glm::vec3(model.objects[v.object].transform * glm::vec4(v.position, 1));
    }
    // Möller & Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997. Both sides of a triangle
    // count.
    const glm::vec3 a = p[1] - p[0], b = p[2] - p[0], q = glm::cross(direction, b);
    const float det = glm::dot(a, q);
    if (det == 0) continue;
    const glm::vec3 s = origin - p[0], r = glm::cross(s, a);
    const float u = glm::dot(s, q) / det, v = glm::dot(direction, r) / det, t = glm::dot(b, r) / det;
    if (u >= 0 && v >= 0 && u + v <= 1 && t > 0) nearest = std::min(nearest, t);
  }
  if (!std::isfinite(nearest)) return std::nullopt;
  return origin + nearest * direction;
}

std::vector<ObjectState> view_states(const Model& model, const ViewOptions& options,
                                     const CameraPlacement& placement) {
  std::vector<ObjectState> states = initial_states(model);
  const Sphere sphere = bounding_sphere(model, {});
  if (options.view == View::kExploded) explode(model, options, sphere, states);
  if (options.view == View::kImpact) throw_fragments(model, options, placement, sphere, states);
  if (options.colors == Colors::kFragment)
    for (std::size_t k = 0; k < states.size(); ++k)
      states[k].tint = glm::vec4(distinct_color(static_cast<std::uint32_t>(k)), 1);
  if (options.colors == Colors::kLevel) {
    const Groups of_level = groups(model, options.level);
    for (std::size_t k = 0; k < states.size(); ++k)
      states[k].tint = glm::vec4(distinct_color(of_level.of_object[k]), 1);
  }
  return states;
}

}  // namespace fracture::render
