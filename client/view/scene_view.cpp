#include "client/view/scene_view.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "client/render/fragment_views.hpp"
#include "client/view/held_cuts.hpp"

namespace fracture::view {
namespace {

using render::ObjectState;

constexpr std::size_t kBallObjects = 64;

/// Combines several boxes, or copies of a ball, into one model with an object for each.
std::shared_ptr<const render::Model> scene_of(const std::vector<scenes::SurfaceMesh>& meshes,
                                              render::Material material) {
  auto model = std::make_shared<render::Model>();
  model->materials.push_back(std::move(material));
  for (const scenes::SurfaceMesh& mesh : meshes) {
    const auto number = static_cast<std::uint32_t>(model->objects.size());
    const auto base = static_cast<std::uint32_t>(model->vertices.size());
    render::Object object;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      render::Vertex vertex;
      vertex.position = mesh.positions[v];
      vertex.normal = mesh.normals[v];
      vertex.object = number;
      model->vertices.push_back(vertex);
      object.bounds.radius = std::max(object.bounds.radius, glm::length(mesh.positions[v]));
    }
    render::Surface surface;
    surface.object = number;
    surface.first_index = static_cast<std::uint32_t>(model->indices.size());
    surface.index_count = static_cast<std::uint32_t>(3 * mesh.triangles.size());
    for (const auto& t : mesh.triangles)
      for (const std::uint32_t v : t) model->indices.push_back(base + v);
    model->objects.push_back(std::move(object));
    model->surfaces.push_back(surface);
  }
  return model;
}

scenes::SurfaceMesh unit_ball() {
  scenes::Turned shape;
  shape.segments = 32;
  constexpr int kRings = 16;
  for (int k = 0; k <= kRings; ++k) {
    const double angle = 3.14159265358979323846 * (0.02 + 0.96 * k / kRings);
    shape.profile.emplace_back(static_cast<float>(std::sin(angle)), static_cast<float>(-std::cos(angle)));
  }
  scenes::SurfaceMesh mesh = scenes::turned(shape);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) mesh.normals[v] = glm::normalize(mesh.positions[v]);
  return mesh;
}

glm::vec3 load_color(float load) {
  const float t = std::clamp(load, 0.f, 1.f);
  return {std::min(1.f, 2 * t), std::min(1.f, 2 - 2 * t), 0.05f};
}

}  // namespace

render::Camera look_at(const glm::vec3& eye, const glm::vec3& target, float aspect) {
  render::Camera camera;
  camera.eye = eye;
  camera.view = glm::lookAt(eye, target, glm::vec3(0, 1, 0));
  camera.projection = glm::perspective(glm::radians(50.f), aspect, 0.05f, 300.f);
  return camera;
}

Expected<SceneView> SceneView::create() {
  Expected<render::Renderer> renderer = render::Renderer::create();
  if (!renderer) return tl::unexpected(renderer.error());
  Expected<DebugLines> lines = DebugLines::create();
  if (!lines) return tl::unexpected(lines.error());
  Expected<effects::DebrisView> debris = effects::DebrisView::create();
  if (!debris) return tl::unexpected(debris.error());
  return SceneView(std::move(*renderer), std::move(*lines), std::move(*debris));
}

Expected<std::uint32_t> SceneView::add(render::SolidLook look, const render::Model& model,
                                       const std::optional<render::SolidPlacement>& solid) {
  auto batch = batches_.find(look);
  if (batch == batches_.end()) {
    Expected<render::GpuModel> gpu = render::GpuModel::batch();
    if (!gpu) return tl::unexpected(gpu.error());
    batch = batches_.emplace(look, Batch{std::move(*gpu), {}, {}}).first;
  }
  const Expected<std::uint32_t> first = batch->second.gpu.append(model, solid, look);
  if (!first) return first;
  const std::vector<ObjectState> states = initial_states(model);
  batch->second.states.insert(batch->second.states.end(), states.begin(), states.end());
  batch->second.uncut.resize(batch->second.states.size(), 0);
  ++uploads_;
  return first;
}

Expected<SceneView::Place> SceneView::upload(const scenes::SceneObject& object, const LayerModel& layer) {
  const render::Model& model = layer ? *layer : *object.mesh->model;
  // The solid texture belongs to the whole object, so it does not change when the object breaks.
  render::SolidPlacement solid;
  solid.frame = bounding_sphere(*object.mesh->model, {});
  solid.frame.radius *= object.look_scale;
  solid.grain = object.grain;
  solid.brick = object.bricks;
  solid.brick_low = glm::vec2(object.mesh->low);
  solid.brick_high = glm::vec2(object.mesh->high);
  const Expected<std::uint32_t> first = add(object.look, model, solid);
  if (!first) return tl::unexpected(first.error());
  return Place{object.look, *first, static_cast<std::uint32_t>(model.objects.size())};
}

void SceneView::hide(const Place& place) {
  std::vector<ObjectState>& states = batches_.at(place.look).states;
  for (std::uint32_t k = 0; k < place.count; ++k) states[place.first + k].visible = false;
}

Expected<void> SceneView::upload_coming(const scenes::Scene& scene,
                                        const std::vector<game::Game::Coming>& coming) {
  // A hit adds only the last layer. The others are already uploaded.
  const auto model_of = [](const game::Game::Coming& next) { return next.fragments->layers.back().model; };
  std::erase_if(waiting_, [&](const auto& entry) {
    return std::none_of(coming.begin(), coming.end(),
                        [&](const game::Game::Coming& next) { return model_of(next) == entry.first; });
  });
  for (const game::Game::Coming& next : coming) {
    const LayerModel model = model_of(next);
    if (waiting_.contains(model) || places_.contains({next.thing, model})) continue;
    const Expected<Place> place = upload(scene.objects[next.scene_object], model);
    if (!place) return tl::unexpected(place.error());
    hide(*place);
    waiting_.emplace(model, *place);
  }
  return {};
}

Expected<SceneView::Place> SceneView::place_of(const scenes::SceneObject& object, std::size_t index,
                                               const LayerModel& model) {
  if (const auto known = places_.find({index, model}); known != places_.end()) return known->second;
  const auto ahead = waiting_.find(model);
  const Expected<Place> place = ahead != waiting_.end() ? ahead->second : upload(object, model);
  if (place) places_.emplace(std::pair(index, model), *place);
  return place;
}

Expected<void> SceneView::show(const scenes::Scene& scene, const game::Moment& moment, std::size_t index,
                               const ViewSettings& settings) {
  const game::Moment::Part& part = moment.parts[index];
  const scenes::SceneObject& object = scene.objects[part.scene_object];
  if (!part.broken) {
    const Expected<Place> place = place_of(object, index, nullptr);
    if (!place) return tl::unexpected(place.error());
    set_whole(*place, part.whole);
    return {};
  }
  for (const game::Decoded::Layer& layer : part.broken->layers) {
    const Expected<Place> place = place_of(object, index, layer.model);
    if (!place) return tl::unexpected(place.error());
    set_fragments(*place, layer, part.fragments, settings.debug);
    if (settings.tier == render::Tier::kHigh)
      hide_held_cuts(object, part, layer,
                     std::span(batches_.at(object.look).uncut).subspan(place->first, place->count));
  }
  return {};
}

void SceneView::set_whole(const Place& place, const world::Pose& pose) {
  Batch& batch = batches_.at(place.look);
  const glm::mat4 world(pose.matrix());
  for (std::uint32_t k = place.first; k < place.first + place.count; ++k) {
    batch.states[k].visible = true;
    batch.states[k].transform = world * batch.gpu.model().objects[k].transform;
  }
}

void SceneView::set_fragments(const Place& place, const game::Decoded::Layer& layer,
                              const std::vector<world::FragmentState>& fragments, DebugView debug) {
  Batch& batch = batches_.at(place.look);
  const std::span<const render::Object> objects(&batch.gpu.model().objects[place.first], place.count);
  const std::span<ObjectState> states(&batch.states[place.first], place.count);
  for (std::size_t k = 0; k < states.size(); ++k) {
    const std::uint32_t fragment = layer.fragment_of_object[k];
    ObjectState& state = states[k];
    if (fragment == game::Decoded::kNoFragment || !fragments[fragment].present) {
      state.visible = false;
      continue;
    }
    const world::FragmentState& f = fragments[fragment];
    state.visible = true;
    // The node's own transform moves to the fragment's origin, so the fragment shrinks about that point.
    state.transform = glm::mat4(f.asset_to_world.matrix()) * objects[k].transform;
    if (f.size < 1) state.transform = glm::scale(state.transform, glm::vec3(f.size));
    state.tint =
        debug == DebugView::kFragments ? glm::vec4(render::distinct_color(f.group), 0.85f) : glm::vec4(0);
  }
}

void SceneView::add_lines(const game::Moment& moment, DebugView debug) {
  for (const game::Moment::Part& part : moment.parts) {
    if (!part.broken) continue;
    const world::FragmentSet& set = world::fragments_of(*part.broken->fragments);
    const std::vector<world::FragmentState>& states = part.fragments;
    if (debug == DebugView::kHulls) {
      for (std::size_t k = 0; k < set.fragments.size(); ++k) {
        if (!states[k].present) continue;
        const glm::vec3 color = render::distinct_color(static_cast<std::uint32_t>(k));
        const world::Pose& pose = states[k].asset_to_world;
        // Connects each corner with its three nearest, which is enough to show the hull.
        for (const world::Hull& hull : set.fragments[k].hulls)
          for (std::size_t a = 0; a < hull.size(); ++a) {
            std::vector<std::pair<double, std::size_t>> near;
            for (std::size_t b = 0; b < hull.size(); ++b)
              if (a != b) near.emplace_back(glm::distance(hull[a], hull[b]), b);
            const std::size_t count = std::min<std::size_t>(3, near.size());
            std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count), near.end());
            for (std::size_t n = 0; n < count; ++n)
              lines_.add(glm::vec3(pose.point(hull[a])), glm::vec3(pose.point(hull[near[n].second])), color);
          }
      }
      continue;
    }
    const std::vector<float>& loads = part.loads;
    for (std::size_t k = 0; k < std::min(set.bonds.size(), loads.size()); ++k) {
      const world::Bond& bond = set.bonds[k];
      if (loads[k] < 0 || !states[bond.a].present || !states[bond.b].present) continue;
      lines_.add(glm::vec3(states[bond.a].asset_to_world.point(set.fragments[bond.a].mass.center)),
                 glm::vec3(states[bond.b].asset_to_world.point(set.fragments[bond.b].mass.center)),
                 load_color(loads[k]));
    }
  }
}

Expected<void> SceneView::upload_furniture(const scenes::Scene& scene) {
  if (furnished_) return {};
  render::Material paint;
  paint.base_color = {0.055f, 0.06f, 0.07f, 1};
  paint.metallic = 0;
  paint.roughness = 0.55f;
  for (const scenes::SceneBox& box : scene.boxes) {
    const glm::vec3 size(2.0 * box.half_sides);
    const auto model =
        scene_of({scenes::box(size, std::min(0.01f, 0.1f * std::min({size.x, size.y, size.z})))}, paint);
    render::SolidPlacement solid;
    solid.frame.radius = 1;  // metres: textures of all boxes have the same scale
    solid.grain = size.x > size.y ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
    const Expected<std::uint32_t> first = add(box.look, *model, solid);
    if (!first) return tl::unexpected(first.error());
    batches_.at(box.look).states[*first].transform = glm::mat4(box.pose.matrix());
  }
  render::Material iron;
  iron.base_color = {0.23f, 0.24f, 0.26f, 1};
  iron.metallic = 1;
  iron.roughness = 0.38f;
  const auto balls = scene_of(std::vector<scenes::SurfaceMesh>(kBallObjects, unit_ball()), iron);
  const Expected<std::uint32_t> first = add(render::SolidLook::kNone, *balls, std::nullopt);
  if (!first) return tl::unexpected(first.error());
  balls_ = *first;
  furnished_ = true;
  return {};
}

void SceneView::place_marks(const game::Moment& moment, const effects::Debris& debris) {
  marks_.clear();
  const game::Moment::Part* part = nullptr;
  for (const effects::Mark& mark : debris.marks()) {
    if (!mark.on_object) {
      marks_.push_back({&mark, mark.position, mark.normal});
      continue;
    }
    if (part == nullptr || part->id != mark.object) {
      const auto found =
          std::find_if(moment.parts.begin(), moment.parts.end(),
                       [&](const game::Moment::Part& other) { return other.id == mark.object; });
      if (found == moment.parts.end()) continue;
      part = &*found;
    }
    // Skips a fragment that is gone, or that broke into pieces, which are a separate object.
    if (mark.fragment >= part->fragments.size() || !part->fragments[mark.fragment].present) continue;
    const world::FragmentState& state = part->fragments[mark.fragment];
    if (state.size < 1) continue;
    const world::Pose& pose = state.asset_to_world;
    marks_.push_back({&mark, glm::vec3(pose.point(glm::dvec3(mark.position))),
                      glm::vec3(pose.rotation * glm::dvec3(mark.normal))});
  }
}

void SceneView::set_balls(const std::vector<world::BallState>& balls) {
  const std::span<ObjectState> states(&batches_.at(render::SolidLook::kNone).states[balls_], kBallObjects);
  for (ObjectState& state : states) state.visible = false;
  std::size_t next = 0;
  for (const world::BallState& ball : balls) {
    if (next >= states.size()) break;
    states[next].visible = true;
    states[next].transform =
        glm::scale(glm::mat4(ball.pose.matrix()), glm::vec3(static_cast<float>(ball.radius)));
    ++next;
  }
}

Expected<effects::DebrisView*> SceneView::debris_for(render::Tier tier) {
  if (tier == render::Tier::kLow) return &debris_;
  if (!high_debris_) {
    Expected<effects::DebrisView> made = effects::DebrisView::create(tier);
    if (!made) return tl::unexpected(made.error());
    high_debris_.emplace(std::move(*made));
  }
  return &*high_debris_;
}

Expected<ViewFigures> SceneView::draw(const scenes::Scene& scene, const game::Moment& moment,
                                      const render::Camera& camera, const ViewSettings& given,
                                      GLuint framebuffer, int width, int height) {
  ViewSettings settings = given;
  if (settings.debug != DebugView::kNone) settings.tier = render::Tier::kLow;
  const auto start = std::chrono::steady_clock::now();
  uploads_ = 0;
  if (const auto furnished = upload_furniture(scene); !furnished) return tl::unexpected(furnished.error());
  std::optional<Error> trouble;
  for (const auto& [key, place] : places_) hide(place);
  for (std::size_t k = 0; k < moment.parts.size(); ++k)
    if (const auto shown = show(scene, moment, k, settings); !shown) trouble = shown.error();
  if (settings.coming != nullptr)
    if (const auto uploaded = upload_coming(scene, *settings.coming); !uploaded) trouble = uploaded.error();
  set_balls(moment.balls);
  std::vector<render::DrawItem> draws;
  for (auto& [look, batch] : batches_)
    draws.push_back({&batch.gpu,
                     batch.states,
                     look,
                     {0, 1, 0},
                     settings.tier == render::Tier::kHigh ? std::span<const std::uint8_t>(batch.uncut)
                                                          : std::span<const std::uint8_t>()});

  render::RenderSettings how = render_settings(scene, settings);
  std::size_t debris_calls = 0;
  if (settings.debris != nullptr && settings.debug == DebugView::kNone) {
    const Expected<effects::DebrisView*> debris = debris_for(settings.tier);
    if (!debris) return tl::unexpected(debris.error());
    place_marks(moment, *settings.debris);
    how.overlay = [&, view = *debris](GLuint into) {
      debris_calls = view->draw(*settings.debris, marks_, camera, into, width, height);
    };
  }
  const render::FrameStats stats = renderer_.draw(draws, camera, how, framebuffer, width, height);
  if (stats.tier != settings.tier) trouble = renderer_.trouble();
  ViewFigures figures{
      stats.draw_calls + debris_calls, stats.shadow_draw_calls, stats.culled, uploads_, 0, stats.tier};
  if (settings.debug == DebugView::kHulls || settings.debug == DebugView::kBonds) {
    add_lines(moment, settings.debug);
    lines_.draw(camera, settings.debug == DebugView::kBonds);
    ++figures.draw_calls;
  }
  figures.submit_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  if (trouble) return tl::unexpected(*trouble);
  return figures;
}

}  // namespace fracture::view
