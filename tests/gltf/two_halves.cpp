#include "tests/gltf/two_halves.hpp"

#include <algorithm>
#include <memory>

#include "common/mesh/material_library.hpp"
#include "common/solid/solid.hpp"

namespace fracture::test {
namespace {

struct Face {
  Vec3f normal, u, v;  ///< u × v = normal
};

constexpr Face kFaces[6] = {{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}}, {{0, 0, -1}, {0, 1, 0}, {1, 0, 0}},
                            {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}, {{0, -1, 0}, {1, 0, 0}, {0, 0, 1}},
                            {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{-1, 0, 0}, {0, 0, 1}, {0, 1, 0}}};

/// A unit cube around its pivot. `cap` is the interior face.
Fragment half(double pivot_x, int cap) {
  Fragment f;
  f.pivot = {pivot_x, 0.5, 0.5};
  f.mass.volume = 1;
  f.mass.area = 6;
  f.mass.center_of_mass = f.pivot;
  f.mass.inertia = {1.0 / 6, 1.0 / 6, 1.0 / 6, 0, 0, 0};
  f.exterior_area = 5;
  f.attributes.uvs.resize(2);
  f.attributes.colors.resize(1);
  const auto add_face = [&](int face) {
    const Face& d = kFaces[face];
    const auto first = static_cast<std::uint32_t>(f.positions.size());
    for (const auto& [a, b] : {std::pair{-0.5f, -0.5f}, {0.5f, -0.5f}, {0.5f, 0.5f}, {-0.5f, 0.5f}}) {
      f.positions.push_back({0.5f * d.normal.x + a * d.u.x + b * d.v.x,
                             0.5f * d.normal.y + a * d.u.y + b * d.v.y,
                             0.5f * d.normal.z + a * d.u.z + b * d.v.z});
      f.attributes.normals.push_back(d.normal);
      f.attributes.tangents.push_back({d.u.x, d.u.y, d.u.z, 1});
      f.attributes.uvs[0].push_back({a + 0.5f, b + 0.5f});
      f.attributes.uvs[1].push_back({a, b});
      f.attributes.colors[0].push_back({1, 0.5f, 0.25f, 1});
    }
    for (const std::uint32_t k : {0u, 1u, 2u, 0u, 2u, 3u}) f.indices.push_back(first + k);
  };
  const auto add_primitive = [&](std::uint32_t material, std::initializer_list<int> faces) {
    const auto first = static_cast<std::uint32_t>(f.indices.size());
    for (const int face : faces) add_face(face);
    f.primitives.push_back({material, first, static_cast<std::uint32_t>(f.indices.size()) - first});
  };
  add_primitive(0, {0, 1});
  add_primitive(1, {2, 3, cap == 4 ? 5 : 4});
  add_primitive(kInteriorMaterial, {cap});
  for (const Vec3f& p : f.positions)  // the corners of the cube, each in three faces
    f.topology.push_back(static_cast<std::uint32_t>(std::find(f.positions.begin(), f.positions.end(), p) -
                                                    f.positions.begin()));
  return f;
}

CollisionHull box(const Vec3f& min, const Vec3f& max) {
  CollisionHull hull;
  for (int k = 0; k < 8; ++k)
    hull.points.push_back({k & 1 ? max.x : min.x, k & 2 ? max.y : min.y, k & 4 ? max.z : min.z});
  hull.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return hull;
}

}  // namespace

FracturedSolid two_halves() {
  auto library = std::make_shared<MaterialLibrary>();
  library->materials = {{{"name", "wood"},
                         {"normalTexture", {{"index", 0}}},
                         {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}, {"texCoord", 1}}}}}},
                        {{"name", "paint"}, {"doubleSided", true}}};
  library->textures = {{{"source", 0}, {"sampler", 0}}};
  library->samplers = {{{"wrapS", 33071}, {"wrapT", 33071}}};
  // The smallest PNG: one grey pixel.
  const std::vector<std::uint8_t> png = {
      0x89, 'P',  'N',  'G',  0x0d, 0x0a, 0x1a, 0x0a, 0,    0,    0,    13,  'I',  'H',  'D',  'R',  0,
      0,    0,    1,    0,    0,    0,    1,    8,    0,    0,    0,    0,   0x3a, 0x7e, 0x9b, 0x55, 0,
      0,    0,    10,   'I',  'D',  'A',  'T',  0x78, 0x9c, 0x63, 0x68, 0,   0,    0,    0x82, 0,    0x81,
      0x77, 0xcd, 0x72, 0xb6, 0,    0,    0,    0,    'I',  'E',  'N',  'D', 0xae, 0x42, 0x60, 0x82};
  library->images.push_back({"grain", "image/png", png});

  auto mesh = std::make_shared<Mesh>();
  mesh->node_names = {"Kiste \xc3\xa4 \"1\""};
  mesh->library = library;
  mesh->copyright = "CC0 \"test\"";

  FracturedSolid made;
  made.set.source = mesh;
  made.set.fragments = {half(0.5, 4), half(1.5, 5)};
  made.set.fragments[0].id = 9007199254740991;  // 2^53 - 1
  made.set.fragments[0].sites = {SiteId{0}};
  made.set.fragments[1].id = 7;
  made.set.fragments[1].sites = {SiteId{1}, SiteId{2}};
  made.set.bonds = {{0, 1, 1.0, {1, 0.5, 0.5}, {1, 0, 0}}};
  made.set.certificate.volume_in = made.set.certificate.volume_out = made.set.certificate.volume_file = 2;
  made.set.certificate.fragments = 2;
  made.set.lattice_step = {0x1p-22, 0x1p-23, 0x1p-23};
  made.report.solid.parts = 1;
  return made;
}

FracturedSolid two_halves_with_hulls() {
  FracturedSolid made = two_halves();
  made.hulls.of_fragment.resize(2);
  made.hulls.of_fragment[0].hulls = {box({-0.4995f, -0.4995f, -0.4995f}, {0.4995f, 0.4995f, 0.4995f})};
  made.hulls.of_fragment[1].hulls = {box({-0.4995f, -0.4995f, -0.4995f}, {0.4995f, 0, 0.4995f}),
                                     box({-0.4995f, 0, -0.4995f}, {0.4995f, 0.4995f, 0.4995f})};
  return made;
}

}  // namespace fracture::test
