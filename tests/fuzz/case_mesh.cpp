#include "tests/fuzz/case_mesh.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <utility>

#include "common/mesh/material_library.hpp"
#include "tests/support/growth_families.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::fuzz {

Box box_of(const Mesh& mesh) {
  Box box;
  for (const auto& t : mesh.triangles)
    for (const std::uint32_t v : t) box.add(to_double(mesh.positions[v]));
  return box;
}

namespace {

Vec3f to_float(const Vec3d& p) {
  return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}
void finish(Mesh& mesh) {
  mesh.material.assign(mesh.triangles.size(), kNoIndex);
  mesh.node.resize(mesh.triangles.size(), 0);
  if (mesh.node_names.empty()) mesh.node_names = {"fuzz"};
}

// ---- shapes

/// Boxes with corners on a small lattice: they touch, overlap in common planes or contain each other; some
/// are inside out.
Mesh lattice_boxes(Bytes& bytes) {
  std::vector<Mesh> all;
  for (std::uint32_t n = 1 + bytes.below(6); n > 0; --n) {
    Vec3d low, high;
    for (int a = 0; a < 3; ++a) {
      low[a] = bytes.below(4);
      high[a] = low[a] + 1 + bytes.below(3);
    }
    Mesh one = test::box(low, high);
    all.push_back(bytes.once_in(5) ? test::reversed(std::move(one)) : std::move(one));
  }
  return test::joined(all);
}

/// Tetrahedra that share corners on a small lattice. Some edges have many triangles, some vertices many fans.
Mesh lattice_tetrahedra(Bytes& bytes) {
  Mesh mesh;
  for (int k = 0; k < 27; ++k) mesh.positions.push_back({float(k % 3), float(k / 3 % 3), float(k / 9)});
  for (std::uint32_t n = 1 + bytes.below(8); n > 0; --n) {
    std::array<std::uint32_t, 4> v;
    for (auto& c : v) c = bytes.below(27);
    const auto at = [&](int k) { return to_double(mesh.positions[v[k]]); };
    if (dot(at(1) - at(0), cross(at(2) - at(0), at(3) - at(0))) < 0) std::swap(v[0], v[1]);
    mesh.triangles.insert(mesh.triangles.end(),
                          {{v[0], v[2], v[1]}, {v[0], v[1], v[3]}, {v[0], v[3], v[2]}, {v[1], v[2], v[3]}});
  }
  finish(mesh);
  return mesh;
}

/// A sheet of n × n squares over a height field, open all around, possibly with holes.
Mesh open_sheet(Bytes& bytes) {
  Mesh mesh;
  const std::uint32_t n = 1 + bytes.below(7);
  const double height = bytes.once_in(3) ? 0 : bytes.unit();
  for (std::uint32_t i = 0; i <= n; ++i)
    for (std::uint32_t j = 0; j <= n; ++j) {
      const double x = static_cast<double>(i) / n, y = static_cast<double>(j) / n;
      mesh.positions.push_back(to_float({x, y, height * bytes.unit()}));
    }
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t j = 0; j < n; ++j) {
      if (bytes.once_in(8)) continue;
      const std::uint32_t a = i * (n + 1) + j, b = a + n + 1;
      mesh.triangles.insert(mesh.triangles.end(), {{a, b, b + 1}, {a, b + 1, a + 1}});
    }
  finish(mesh);
  return mesh;
}

Mesh polygon_prism(Bytes& bytes) {
  std::vector<Vec2d> polygon;
  for (std::uint32_t n = 3 + bytes.below(12); n > 0; --n) {
    const double x = bytes.below(9) / 8.0, y = bytes.below(9) / 8.0;  // corners coincide, edges overlap
    polygon.push_back({x, y});
  }
  return test::prism_over(polygon);
}

Mesh box_without_faces(Bytes& bytes) {
  std::vector<int> faces;
  const std::uint32_t missing = bytes.byte();
  for (int f = 0; f < 6; ++f)
    if (missing >> f & 1) faces.push_back(f);
  if (faces.size() == 6) faces.pop_back();
  return test::cube_without(faces);
}

Mesh shape_of(Bytes& bytes, std::string& words, std::vector<Vec3d>& sites) {
  const auto& families = test::growth_families();
  static const std::vector<test::NamedMesh> closed = test::closed_shapes();
  const std::uint32_t kind = bytes.below(12);
  if (kind < 5) {
    const test::GrowthFamily& family = families[bytes.below(static_cast<std::uint32_t>(families.size()))];
    const std::string name = family.name;
    // Some families make hundreds of triangles for each step.
    const std::uint32_t size = 1 + bytes.below(name == "instances" ? 3 : name == "hub" ? 40 : 60);
    const std::uint64_t seed = bytes.byte();
    test::GrowthInput input = family.make(size, seed);
    words += name + "(" + std::to_string(size) + ", seed " + std::to_string(seed) + ")";
    sites.insert(sites.end(), input.sites.begin(), input.sites.end());
    return std::move(input.mesh);
  }
  if (kind == 5) {
    const test::NamedMesh& one = closed[bytes.below(static_cast<std::uint32_t>(closed.size()))];
    words += one.name;
    return one.mesh;
  }
  if (kind == 6) return words += "lattice_boxes", lattice_boxes(bytes);
  if (kind == 7) return words += "lattice_tetrahedra", lattice_tetrahedra(bytes);
  if (kind == 8) return words += "open_sheet", open_sheet(bytes);
  if (kind == 9) return words += "polygon_prism", polygon_prism(bytes);
  if (kind == 10) return words += "box_without_faces", box_without_faces(bytes);
  switch (bytes.below(5)) {
    case 0:
      return words += "nested_spheres", test::nested_spheres(1 + static_cast<int>(bytes.below(5)), 80);
    case 1:
      return words += "self_crossing_tube", test::self_crossing_tube(24, 6);
    case 2:
      return words += "klein_bottle", test::klein_bottle(16, 8);
    case 3:
      return words += "open_quad", test::open_quad();
    default:
      return words += "cube", test::cube(1 + static_cast<int>(bytes.below(6)));
  }
}

// ---- damage and placement

void damage(Bytes& bytes, Mesh& mesh, std::string& words) {
  const auto triangles = static_cast<std::uint32_t>(mesh.triangles.size()),
             vertices = static_cast<std::uint32_t>(mesh.positions.size());
  if (triangles == 0 || vertices == 0) return;
  const auto some_triangle = [&] { return static_cast<std::uint32_t>(bytes.word() % mesh.triangles.size()); };
  const auto some_vertex = [&] { return static_cast<std::uint32_t>(bytes.word() % vertices); };
  const double size = box_of(mesh).longest_side();
  const std::uint32_t many = 1 + bytes.below(4);
  const std::uint32_t kind = bytes.below(8);
  static const char* const kNames[] = {"drop",  "flip", "duplicate", "collapse",
                                       "nudge", "snap", "unindex",   "turn"};
  words += std::string(" ") + kNames[kind];
  for (std::uint32_t n = 0; n < many && mesh.triangles.size() > 1; ++n) {
    if (kind == 0) mesh.triangles.erase(mesh.triangles.begin() + some_triangle());
    if (kind == 1) {
      auto& t = mesh.triangles[some_triangle()];
      std::swap(t[1], t[2]);
    }
    if (kind == 2) {
      const auto copy = mesh.triangles[some_triangle()];
      mesh.triangles.push_back(copy);
    }
    if (kind == 3) {
      const std::uint32_t to = some_vertex();
      mesh.positions[to] = mesh.positions[some_vertex()];
    }
    if (kind == 4) {
      Vec3f& p = mesh.positions[some_vertex()];
      const double by = size * std::pow(10.0, -bytes.between(0, 9));
      p = to_float(to_double(p) + Vec3d{by * bytes.unit(), by * bytes.unit(), by * bytes.unit()});
    }
  }
  if (kind == 5) {
    const double step = size / (2 << bytes.below(5));
    for (Vec3f& p : mesh.positions)
      p = to_float(
          {std::round(p.x / step) * step, std::round(p.y / step) * step, std::round(p.z / step) * step});
  }
  finish(mesh);
  if (kind == 6) mesh = test::unindexed(mesh);
  if (kind == 7) {  // rotate by an angle that no float represents exactly
    const double angle = bytes.between(0, 6.3), c = std::cos(angle), s = std::sin(angle);
    for (Vec3f& p : mesh.positions) p = to_float({c * p.x - s * p.y, s * p.x + c * p.y, p.z});
  }
  finish(mesh);
}

void put_in_place(Bytes& bytes, Mesh& mesh, std::vector<Vec3d>& sites, std::string& words) {
  Vec3d scale{1, 1, 1}, by{0, 0, 0};
  if (bytes.once_in(4)) scale[static_cast<int>(bytes.below(3))] = std::pow(10.0, -bytes.between(0, 5));
  if (bytes.once_in(3)) scale = std::pow(10.0, bytes.between(-12, 9)) * scale;
  mesh = test::scaled(std::move(mesh), scale);
  if (bytes.once_in(3)) {
    const double distance = box_of(mesh).longest_side() * std::pow(10.0, bytes.between(0, 6));
    for (int a = 0; a < 3; ++a) by[a] = distance * bytes.between(-1, 1);
    if (bytes.once_in(2)) by[static_cast<int>(bytes.below(3))] = 0;
    mesh = test::translated(std::move(mesh), by);
  }
  for (Vec3d& p : sites) p = Vec3d{p.x * scale.x, p.y * scale.y, p.z * scale.z} + by;
  char text[200];
  std::snprintf(text, sizeof text, ", scaled by %.9g %.9g %.9g, moved by %.9g %.9g %.9g", scale.x, scale.y,
                scale.z, by.x, by.y, by.z);
  words += text;
}

}  // namespace

Mesh mesh_of(Bytes& bytes, std::string& words, std::vector<Vec3d>& sites) {
  Mesh mesh = shape_of(bytes, words, sites);
  for (std::uint32_t more = bytes.below(6) > 3 ? 1 + bytes.below(2) : 0; more > 0; --more) {
    words += " + ";
    std::vector<Vec3d> ignored;
    Mesh other = shape_of(bytes, words, ignored);
    if (bytes.once_in(4)) other = test::reversed(std::move(other));
    const double size = bytes.once_in(3) ? 0.25 + 0.25 * bytes.below(4) : 1;
    const Vec3d by{0.5 * bytes.below(5) - 1, 0.5 * bytes.below(5) - 1, 0.5 * bytes.below(5) - 1};
    mesh = test::joined({mesh, test::translated(test::scaled(std::move(other), {size, size, size}), by)});
  }
  for (std::uint32_t n = bytes.below(8) > 4 ? 1 + bytes.below(3) : 0; n > 0; --n) damage(bytes, mesh, words);
  put_in_place(bytes, mesh, sites, words);
  finish(mesh);
  static const auto two_materials = [] {
    auto library = std::make_shared<MaterialLibrary>();
    library->materials = nlohmann::json::array({{{"name", "one"}}, {{"name", "two"}}});
    return library;
  }();
  mesh.library = two_materials;
  for (std::size_t t = 0; t < mesh.material.size(); ++t) mesh.material[t] = t % 3 == 0 ? 1 : 0;
  return mesh;
}

}  // namespace fracture::fuzz
