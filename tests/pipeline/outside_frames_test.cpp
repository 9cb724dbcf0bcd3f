// The frames of normal maps on the outside of fragments, compared with those of the source: for mirrored and sheared nodes, and
// for skins with joints that mirror. Each triangle of the outside is taken back to the source's box.
#include <gtest/gtest.h>

#include <cmath>

#include "common/import/transform.hpp"
#include "tests/import/make_files.hpp"
#include "tests/support/fractured.hpp"

namespace fracture::test {
namespace {

using nlohmann::json;

/// The frame of a face of the box: its normal, and a tangent with its handedness.
struct Face {
  Vec3d normal, tangent;
  double handedness;
  Vec3d bitangent() const { return handedness * cross(normal, tangent); }
};

Vec3d axis(int a, double length = 1) {
  Vec3d v;
  v[a] = length;
  return v;
}

/// The face on the side `sign` of an axis. Neighbouring faces have different handedness.
Face face(int a, double sign) {
  return {axis(a, sign), axis((a + 1) % 3), (a % 2 == 0) == (sign > 0) ? 1.0 : -1.0};
}

/// The box [-1, 1]³ with four vertices for each face, and a material with a normal map.
struct Box24 : Tetrahedron {
  Box24() {
    binary.clear();
    json["accessors"] = nlohmann::json::array();
    json["bufferViews"] = nlohmann::json::array();
    std::string positions, normals, tangents, uvs, indices;
    std::uint16_t base = 0;
    for (int a = 0; a < 3; ++a)
      for (const double sign : {-1.0, 1.0}) {
        const Face f = face(a, sign);
        const Vec3d right = f.tangent, up = cross(f.normal, right);
        for (const auto& [r, u] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
          const Vec3d p = f.normal + static_cast<double>(r) * right + static_cast<double>(u) * up;
          top.push_back(p.y > 0);
          for (int k = 0; k < 3; ++k) put<float>(positions, {static_cast<float>(p[k])});
          for (int k = 0; k < 3; ++k) put<float>(normals, {static_cast<float>(f.normal[k])});
          for (int k = 0; k < 3; ++k) put<float>(tangents, {static_cast<float>(right[k])});
          put<float>(tangents, {static_cast<float>(f.handedness)});
          put<float>(uvs, {0.5f + 0.5f * static_cast<float>(r), 0.5f + 0.5f * static_cast<float>(u)});
        }
        for (const int corner : {0, 1, 2, 0, 2, 3})
          put<std::uint16_t>(indices, {static_cast<std::uint16_t>(base + corner)});
        base = static_cast<std::uint16_t>(base + 4);
      }
    nlohmann::json& attributes = primitive()["attributes"];
    attributes["POSITION"] = add_accessor(positions, 5126, 24, "VEC3");
    attributes["NORMAL"] = add_accessor(normals, 5126, 24, "VEC3");
    attributes["TANGENT"] = add_accessor(tangents, 5126, 24, "VEC4");
    attributes["TEXCOORD_0"] = add_accessor(uvs, 5126, 24, "VEC2");
    primitive()["indices"] = add_accessor(indices, 5123, 36, "SCALAR");
    primitive()["material"] = 0;
    json["materials"] = {{{"name", "bumpy"}, {"normalTexture", {{"index", 0}}}}};
    json["textures"] = {{{"source", 0}}};
    json["images"] = {{{"uri", "data:image/png;base64,iVBORw0KGgo="}}};
  }
  std::vector<bool> top;  ///< per vertex: y > 0
};

/// Rows of the inverse of the linear part, times the position.
Vec3d back(const Transform& m, const Vec3d& place) {
  const Vec3d p = place - m.t;
  const double det = m.determinant();
  return (1 / det) * Vec3d{dot(cross(m.y, m.z), p), dot(cross(m.z, m.x), p), dot(cross(m.x, m.y), p)};
}

Vec3d unit(const Vec3d& v) { return (1 / length(v)) * v; }

/// Breaks the file and compares each corner of the outside with the source, which `m` moves to its place.
void expect_frames_of_source(const Box24& file, const Transform& m) {
  Expected<Mesh> mesh = import_text(file.glb(), MeshFormat::kGlb);
  ASSERT_TRUE(mesh) << mesh.error().detail;
  FractureParameters parameters;
  parameters.sites = 12;
  const Fractured made = fracture_mesh(*mesh, parameters);
  EXPECT_EQ(made.solid.report.flipped, 0u) << "the file's triangles face outwards";
  double area = 0;
  for (const Fragment& f : made.set.fragments) {
    ASSERT_EQ(f.attributes.tangents.size(), f.positions.size());
    for (const FragmentPrimitive& primitive : f.primitives) {
      if (primitive.material != 0) continue;  // a cut
      for (std::uint32_t k = primitive.first_index; k < primitive.first_index + primitive.index_count;
           k += 3) {
        Vec3d corners[3], center;
        for (std::size_t c = 0; c < 3; ++c) {
          corners[c] = to_double(f.positions[f.indices[k + c]]) + f.pivot;
          center = center + (1.0 / 3) * corners[c];
        }
        const Vec3d outwards = cross(corners[1] - corners[0], corners[2] - corners[0]);
        if (length(outwards) < 1e-5) continue;  // on an edge of the box, the face would be unclear
        area += 0.5 * length(outwards);
        const Vec3d q = back(m, center);
        int a = 0;
        for (int other = 1; other < 3; ++other)
          if (std::fabs(q[other]) > std::fabs(q[a])) a = other;
        ASSERT_NEAR(std::fabs(q[a]), 1, 1e-4) << "the outside is not where the source is";
        const Face source = face(a, q[a] > 0 ? 1 : -1);
        if (length(outwards) > 1e-3) {  // thinner triangles lean by the rounding of their corners
          EXPECT_GT(dot(unit(outwards), unit(m.normal(source.normal))), 0.999);
        }
        for (std::size_t c = 0; c < 3; ++c) {
          const std::uint32_t v = f.indices[k + c];
          const Vec3d n = to_double(f.attributes.normals[v]);
          const Vec4f& t4 = f.attributes.tangents[v];
          const Vec3d t{t4.x, t4.y, t4.z};
          EXPECT_GT(dot(n, unit(m.normal(source.normal))), 0.9999);
          EXPECT_GT(dot(t, unit(m.linear(source.tangent))), 0.9999);
          EXPECT_EQ(std::fabs(t4.w), 1);
          EXPECT_GT(t4.w * dot(cross(n, t), unit(m.linear(source.bitangent()))), 0.1) << "handedness";
        }
      }
    }
  }
  double whole = 0;
  for (int b = 0; b < 3; ++b) whole += 8 * length(cross(b == 0 ? m.y : m.x, b == 2 ? m.y : m.z));
  EXPECT_NEAR(area / whole, 1, 1e-3) << "all of the outside was sampled";
}

TEST(OutsideFrames, AreThoseOfAMirroredNode) {
  Box24 file;
  file.node()["scale"] = {-2, 1, 1};
  expect_frames_of_source(file, {{-2, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}});
}

TEST(OutsideFrames, AreThoseOfShearedNodes) {
  for (const double mirrored : {-1, 1}) {
    Box24 file;
    const std::array<double, 4> turn{0.3, 0.2, 0.1, 0.9273618495495703};
    file.json["nodes"] = {{{"scale", {-1, 2, 0.5}}, {"children", {1}}},
                          {{"mesh", 0}, {"rotation", turn}, {"scale", {1, 3 * mirrored, 1}}}};
    const Transform above{{-1, 0, 0}, {0, 2, 0}, {0, 0, 0.5}, {0, 0, 0}};
    expect_frames_of_source(file, above * compose({0, 0, 0}, turn, {1, 3 * mirrored, 1}));
  }
}

/// Skins the box to two joints, which have these nodes. The second one moves the upper vertices.
Box24 skinned(const json& lower, const json& upper) {
  Box24 file;
  std::string joints, weights;
  for (const bool top : file.top) {
    put<std::uint8_t>(joints, {static_cast<std::uint8_t>(top ? 1 : 0), 0, 0, 0});
    put<float>(weights, {1, 0, 0, 0});
  }
  file.primitive()["attributes"]["JOINTS_0"] = file.add_accessor(joints, 5121, 24, "VEC4");
  file.primitive()["attributes"]["WEIGHTS_0"] = file.add_accessor(weights, 5126, 24, "VEC4");
  file.json["skins"] = json::array({{{"joints", {1, 2}}}});
  file.json["nodes"] = json::array({{{"mesh", 0}, {"skin", 0}, {"translation", {100, 0, 0}}}, lower, upper});
  file.json["scenes"] = json::array({{{"nodes", {0, 1, 2}}}});
  return file;
}

TEST(OutsideFrames, AreThoseOfASkinWhoseJointsMirrorAlike) {
  const json joint = {{"scale", {-1, 1, 1}}};
  expect_frames_of_source(skinned(joint, joint), {{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}});
}

// The upper joint is 1 m higher, so y = -1 … 1 becomes -1 … 2.
TEST(OutsideFrames, AreThoseOfASkinWhoseJointsMirrorAtDifferentPlaces) {
  expect_frames_of_source(
      skinned({{"scale", {-1, 1, 1}}}, {{"scale", {-1, 1, 1}}, {"translation", {0, 1, 0}}}),
      {{-1, 0, 0}, {0, 1.5, 0}, {0, 0, 1}, {0, 0.5, 0}});
  expect_frames_of_source(skinned(json::object(), {{"translation", {0, 1, 0}}}),
                          {{1, 0, 0}, {0, 1.5, 0}, {0, 0, 1}, {0, 0.5, 0}});
}

}  // namespace
}  // namespace fracture::test
