#include "client/scenes/solid_shapes.hpp"

#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "common/mesh/gltf_component.hpp"

namespace fracture::scenes {
namespace {

void append(std::string& bytes, const void* data, std::size_t size) {
  bytes.append(static_cast<const char*>(data), size);
}
void append_u32(std::string& bytes, std::uint32_t x) { append(bytes, &x, sizeof x); }

/// The face of a cube towards +axis (side 1) or -axis (side -1). (u, v) is a point on it and `out` its
/// distance along the axis; u, v, axis are right-handed.
struct Face {
  int axis;
  float side;
  glm::vec3 at(float u, float v, float out) const {
    glm::vec3 p;
    p[axis] = side * out;
    p[(axis + 1) % 3] = side > 0 ? u : v;
    p[(axis + 2) % 3] = side > 0 ? v : u;
    return p;
  }
};

}  // namespace

void SurfaceMesh::triangle(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
  const glm::vec3 n = glm::normalize(glm::cross(b - a, c - a));
  const auto base = static_cast<std::uint32_t>(positions.size());
  for (const glm::vec3& p : {a, b, c}) {
    positions.push_back(p);
    normals.push_back(n);
  }
  triangles.push_back({base, base + 1, base + 2});
}

void SurfaceMesh::quad(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d) {
  const glm::vec3 n = glm::normalize(glm::cross(c - a, d - b));
  const auto base = static_cast<std::uint32_t>(positions.size());
  for (const glm::vec3& p : {a, b, c, d}) {
    positions.push_back(p);
    normals.push_back(n);
  }
  triangles.push_back({base, base + 1, base + 2});
  triangles.push_back({base, base + 2, base + 3});
}

SurfaceMesh box(const glm::vec3& size, float bevel) {
  SurfaceMesh mesh;
  const glm::vec3 h = 0.5f * size;
  // The corner of a face, moved inwards by the bevel along the two other axes.
  const auto corner = [&](int axis, const glm::ivec3& s) {
    glm::vec3 p;
    for (int k = 0; k < 3; ++k) p[k] = static_cast<float>(s[k]) * (k == axis ? h[k] : h[k] - bevel);
    return p;
  };
  const auto sign = [](int axis, int a, int b, int c) {
    glm::ivec3 s;
    s[axis] = a;
    s[(axis + 1) % 3] = b;
    s[(axis + 2) % 3] = c;
    return s;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (const int side : {1, -1}) {
      const glm::vec3 p = corner(axis, sign(axis, side, -1, -1)), q = corner(axis, sign(axis, side, 1, -1)),
                      r = corner(axis, sign(axis, side, 1, 1)), s = corner(axis, sign(axis, side, -1, 1));
      if (side > 0)
        mesh.quad(p, q, r, s);
      else
        mesh.quad(p, s, r, q);
    }
  if (!(bevel > 0)) return mesh;
  for (int axis = 0; axis < 3; ++axis) {  // bevels along `axis`, between the two other axes' faces
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const int su : {1, -1})
      for (const int sv : {1, -1}) {
        const glm::ivec3 low = sign(axis, -1, su, sv), high = sign(axis, 1, su, sv);
        const glm::vec3 a = corner(u, low), b = corner(u, high), c = corner(v, high), d = corner(v, low);
        if (su * sv > 0)
          mesh.quad(a, d, c, b);
        else
          mesh.quad(a, b, c, d);
      }
  }
  for (const int x : {1, -1})
    for (const int y : {1, -1})
      for (const int z : {1, -1}) {
        const glm::ivec3 s(x, y, z);
        if (x * y * z > 0)
          mesh.triangle(corner(0, s), corner(1, s), corner(2, s));
        else
          mesh.triangle(corner(0, s), corner(2, s), corner(1, s));
      }
  return mesh;
}

SurfaceMesh crate(float side, float border, float depth, float wall) {
  SurfaceMesh mesh;
  const float h = side / 2, i = h - border, floor = h - depth, inner = h - wall;
  for (int axis = 0; axis < 3; ++axis)
    for (const float s : {1.f, -1.f}) {
      const Face f{axis, s};
      const auto ring = [&](float x, float out) {
        return std::array{f.at(-x, -x, out), f.at(x, -x, out), f.at(x, x, out), f.at(-x, x, out)};
      };
      const auto outside = ring(h, h), rim = ring(i, h), sunk = ring(i, floor);
      for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t n = (k + 1) % 4;
        mesh.quad(outside[k], outside[n], rim[n], rim[k]);
        mesh.quad(rim[k], rim[n], sunk[n], sunk[k]);
      }
      mesh.quad(sunk[0], sunk[1], sunk[2], sunk[3]);
      const auto cavity = ring(inner, inner);  // seen from the inside
      mesh.quad(cavity[3], cavity[2], cavity[1], cavity[0]);
    }
  return mesh;
}

SurfaceMesh turned(const Turned& shape) {
  SurfaceMesh mesh;
  const std::size_t rings = shape.profile.size();
  const int n = shape.segments;
  const auto at = [&](std::size_t ring, int segment) {
    const auto [radius, height] = std::pair(shape.profile[ring].x, shape.profile[ring].y);
    const double angle = 2 * 3.14159265358979323846 * (segment % n) / n;
    const bool groove = shape.flutes > 0 && height >= shape.fluted_from && height <= shape.fluted_to;
    const double depth = groove ? shape.groove * 0.5 * (1 - std::cos(shape.flutes * angle)) : 0;
    const auto r = static_cast<float>(radius - depth);
    return glm::vec3(r * static_cast<float>(std::cos(angle)), height,
                     r * static_cast<float>(std::sin(angle)));
  };
  for (std::size_t k = 0; k + 1 < rings; ++k)
    for (int s = 0; s < n; ++s) mesh.quad(at(k, s), at(k + 1, s), at(k + 1, s + 1), at(k, s + 1));
  const glm::vec3 bottom(0, shape.profile.front().y, 0), top(0, shape.profile.back().y, 0);
  for (int s = 0; s < n; ++s) {
    mesh.triangle(bottom, at(0, s), at(0, s + 1));
    mesh.triangle(top, at(rings - 1, s + 1), at(rings - 1, s));
  }
  return mesh;
}

std::string to_glb(const SurfaceMesh& mesh, const std::string& name, const glm::vec4& color) {
  std::string binary;
  append(binary, mesh.positions.data(), mesh.positions.size() * sizeof(glm::vec3));
  append(binary, mesh.normals.data(), mesh.normals.size() * sizeof(glm::vec3));
  const std::size_t vertex_bytes = mesh.positions.size() * sizeof(glm::vec3);
  append(binary, mesh.triangles.data(), mesh.triangles.size() * 12);
  glm::vec3 low(std::numeric_limits<float>::max()), high(-low);
  for (const glm::vec3& p : mesh.positions) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const auto vec3 = [](const glm::vec3& v) { return nlohmann::json{v.x, v.y, v.z}; };
  const std::size_t count = mesh.positions.size();
  const nlohmann::json document = {
      {"asset", {{"version", "2.0"}, {"generator", "fracture-client"}}},
      {"scene", 0},
      {"scenes", {{{"nodes", {0}}}}},
      {"nodes", {{{"name", name}, {"mesh", 0}}}},
      {"meshes",
       {{{"name", name},
         {"primitives",
          {{{"attributes", {{"POSITION", 0}, {"NORMAL", 1}}}, {"indices", 2}, {"material", 0}}}}}}},
      {"materials",
       {{{"name", name},
         {"pbrMetallicRoughness",
          {{"baseColorFactor", {color.r, color.g, color.b, color.a}},
           {"metallicFactor", 0},
           {"roughnessFactor", 0.8}}}}}},
      {"accessors",
       {{{"bufferView", 0},
         {"componentType", component_type::kFloat},
         {"count", count},
         {"type", "VEC3"},
         {"min", vec3(low)},
         {"max", vec3(high)}},
        {{"bufferView", 1}, {"componentType", component_type::kFloat}, {"count", count}, {"type", "VEC3"}},
        {{"bufferView", 2},
         {"componentType", component_type::kUnsignedInt},
         {"count", 3 * mesh.triangles.size()},
         {"type", "SCALAR"}}}},
      {"bufferViews",
       {{{"buffer", 0}, {"byteOffset", 0}, {"byteLength", vertex_bytes}, {"target", 34962}},
        {{"buffer", 0}, {"byteOffset", vertex_bytes}, {"byteLength", vertex_bytes}, {"target", 34962}},
        {{"buffer", 0},
         {"byteOffset", 2 * vertex_bytes},
         {"byteLength", 12 * mesh.triangles.size()},
         {"target", 34963}}}},
      {"buffers", {{{"byteLength", binary.size()}}}}};
  std::string text = document.dump();
  text.append((4 - text.size() % 4) % 4, ' ');
  binary.append((4 - binary.size() % 4) % 4, '\0');
  std::string glb = "glTF";
  append_u32(glb, 2);
  append_u32(glb, static_cast<std::uint32_t>(12 + 8 + text.size() + 8 + binary.size()));
  append_u32(glb, static_cast<std::uint32_t>(text.size()));
  append_u32(glb, 0x4E4F534Au);  // "JSON"
  glb += text;
  append_u32(glb, static_cast<std::uint32_t>(binary.size()));
  append_u32(glb, 0x004E4942u);  // "BIN"
  glb += binary;
  return glb;
}

}  // namespace fracture::scenes
