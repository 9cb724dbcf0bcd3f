// glTF scenes of instances: nodes that place one mesh at many places.
#pragma once

#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "common/base/similarity.hpp"
#include "common/contacts/contacts.hpp"
#include "common/solid/instances.hpp"
#include "tests/import/make_files.hpp"
#include "tests/support/fractured.hpp"

namespace fracture::test {

/// A place of an instance. The scale can differ by axis, and can be negative.
struct Place {
  Vec3d translation;
  Quaternion rotation{0, 0, 0, 1};
  Vec3d scale{1, 1, 1};
};

inline Quaternion about_y(double angle) { return {0, std::sin(angle / 2), 0, std::cos(angle / 2)}; }

/// A mesh of tetrahedra that share no vertex: `tufts` blades of grass around the origin, 0.2 m from it at most, with UVs.
class Grass {
 public:
  explicit Grass(int blades) : blades_(blades) {
    for (int k = 0; k < blades; ++k) {
      const double angle = 2.4 * k, out = 0.012 * std::sqrt(k + 1.0);
      const Vec3d foot{out * std::cos(angle), 0, out * std::sin(angle)};
      const Vec3d tip = foot + Vec3d{0.1 * std::cos(angle), 0.2 + 0.005 * k, 0.1 * std::sin(angle)};
      for (const Vec3d& p : {foot, foot + Vec3d{0.004, 0, 0}, foot + Vec3d{0, 0, 0.004}, tip})
        points_.push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
    }
  }
  const std::vector<Vec3f>& points() const { return points_; }

  /// A file with one node for each place.
  std::string glb(const std::vector<Place>& places) const {
    nlohmann::json document = document_of();
    document["nodes"] = nlohmann::json::array();
    nlohmann::json roots = nlohmann::json::array();
    for (std::size_t k = 0; k < places.size(); ++k) {
      const auto& [t, r, s] = places[k];
      document["nodes"].push_back({{"mesh", 0},
                                   {"name", "grass"},
                                   {"translation", {t.x, t.y, t.z}},
                                   {"rotation", {r[0], r[1], r[2], r[3]}},
                                   {"scale", {s.x, s.y, s.z}}});
      roots.push_back(k);
    }
    document["scenes"] = {{{"nodes", roots}}};
    return make_glb(document, binary());
  }

 private:
  std::string binary() const {
    std::string bytes;
    for (const Vec3f& p : points_) put<float>(bytes, {p.x, p.y, p.z});
    for (std::size_t k = 0; k < points_.size(); ++k)
      put<float>(bytes, {0.25f * static_cast<float>(k % 4), 0.5f});
    for (int k = 0; k < blades_; ++k)
      for (const int corner : {0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0})
        put<std::uint16_t>(bytes, {static_cast<std::uint16_t>(4 * k + corner)});
    return bytes;
  }
  nlohmann::json document_of() const {
    const std::size_t count = points_.size(), corners = 12 * static_cast<std::size_t>(blades_);
    return {{"asset", {{"version", "2.0"}}},
            {"scene", 0},
            {"meshes",
             {{{"primitives", {{{"attributes", {{"POSITION", 0}, {"TEXCOORD_0", 1}}}, {"indices", 2}}}}}}},
            {"accessors",
             {{{"bufferView", 0}, {"componentType", 5126}, {"count", count}, {"type", "VEC3"}},
              {{"bufferView", 1}, {"componentType", 5126}, {"count", count}, {"type", "VEC2"}},
              {{"bufferView", 2}, {"componentType", 5123}, {"count", corners}, {"type", "SCALAR"}}}},
            {"bufferViews",
             {{{"buffer", 0}, {"byteOffset", 0}, {"byteLength", 12 * count}},
              {{"buffer", 0}, {"byteOffset", 12 * count}, {"byteLength", 8 * count}},
              {{"buffer", 0}, {"byteOffset", 20 * count}, {"byteLength", 2 * corners}}}},
            {"buffers", {{{"byteLength", 20 * count + 2 * corners}}}}};
  }

  int blades_;
  std::vector<Vec3f> points_;
};

/// Places on a square grid with a spacing of 1 m, turned and scaled from 0.6 to 1.4.
inline std::vector<Place> meadow(int count) {
  const int side = static_cast<int>(std::ceil(std::sqrt(count)));
  std::vector<Place> places;
  for (int k = 0; k < count; ++k) {
    const double scale = 0.6 + 0.2 * ((2 * k) % 5);
    places.push_back({Vec3d{static_cast<double>(k % side), 0.1 * (k % 3), static_cast<double>(k / side)},
                      about_y(0.7 * k),
                      {scale, scale, scale}});
  }
  return places;
}

/// The solid of a file, as the server prepares it. Throws std::runtime_error with the detail of any error.
inline Solid solid_of_glb(const std::string& glb) {
  Expected<Mesh> mesh = import_text(glb, MeshFormat::kGlb);
  if (!mesh) throw std::runtime_error(mesh.error().detail);
  Expected<Solid> solid = make_solid(std::make_shared<Mesh>(std::move(*mesh)), {}, {});
  if (!solid) throw std::runtime_error(solid.error().detail);
  keep_contacts(*solid, {}, {});
  keep_instances(*solid, {});
  return std::move(*solid);
}

/// The nodes of fragments, in order.
inline std::vector<nlohmann::json> bodies_of(const nlohmann::json& document) {
  std::vector<nlohmann::json> found;
  for (const nlohmann::json& node : document["nodes"])
    if (node.contains("extras") && node["extras"].contains("fracture") &&
        node["extras"]["fracture"].contains("id"))
      found.push_back(node);
  return found;
}

}  // namespace fracture::test
