#include "tests/fuzz/fracture_case.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "common/mesh/material_library.hpp"
#include "tests/support/growth_families.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::fuzz {

std::uint64_t Bytes::word() {
  std::uint64_t w = 0;
  for (int k = 0; k < 8; ++k) w = w << 8 | byte();
  return w;
}
std::uint32_t Bytes::below(std::uint32_t n) {
  std::uint32_t v = byte();
  if (n > 256) v = v << 8 | byte();
  return v % n;
}
double Bytes::unit() {
  const std::uint32_t high = byte(), low = byte();
  return (high << 8 | low) / 65535.0;
}

namespace {

Vec3f to_float(const Vec3d& p) {
  return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}
Box box_of(const Mesh& mesh) {
  Box box;
  for (const auto& t : mesh.triangles)
    for (const std::uint32_t v : t) box.add(to_double(mesh.positions[v]));
  return box;
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

// ---- parameters

/// The scene for which parameter values are drawn.
struct Scene {
  Box box;
  double size, volume;
  std::uint32_t nodes, materials;
};

double number_of(Bytes& bytes, const ParameterSpec& spec, const Scene& scene) {
  double v;
  if (bytes.once_in(12))
    v = bytes.once_in(2) ? spec.high : spec.low;
  else if (spec.unit == "m")
    v = scene.size * std::pow(10.0, bytes.between(-3, 0.3));
  else if (spec.unit == "m³")
    v = scene.volume * std::pow(10.0, bytes.between(-4, 0.3));
  else if (spec.default_value.is_number() && spec.default_value.get<double>() > 0)
    v = spec.default_value.get<double>() * std::pow(10.0, bytes.between(-1.5, 1.5));
  else
    v = bytes.between(spec.low, std::min(spec.high, 100.0));
  return std::clamp(v, spec.low, spec.high);
}
std::uint64_t integer_of(Bytes& bytes, const ParameterSpec& spec) {
  if (spec.max > 1ull << 40) return spec.min + bytes.word() % (spec.max - spec.min);  // a seed
  if (bytes.once_in(10)) return spec.min;
  const double low = std::log(std::max<double>(static_cast<double>(spec.min), 1)),
               high =
                   std::log(std::max<double>(static_cast<double>(std::min<std::uint64_t>(spec.max, 300)), 1));
  const double v = std::exp(bytes.between(low, std::max(low, high)));
  return std::clamp(static_cast<std::uint64_t>(v), spec.min, spec.max);
}
nlohmann::json vector_of(Bytes& bytes, const ParameterSpec& spec, const Scene& scene, bool place) {
  nlohmann::json v = nlohmann::json::array();
  const std::uint32_t axis = bytes.below(6);  // 3 to 5: any direction
  for (std::uint32_t a = 0; a < 3; ++a) {
    const int k = static_cast<int>(a);
    double c = place ? scene.box.min[k] + bytes.between(-0.1, 1.1) * (scene.box.max[k] - scene.box.min[k])
               : axis < 3 ? (a == axis ? 1 : 0)
                          : bytes.between(-1, 1);
    if (spec.low > 0) c = scene.size * std::pow(10.0, bytes.between(-1.2, 0));  // lengths
    v.push_back(std::clamp(c, spec.low, spec.high));
  }
  return v;
}

nlohmann::json value_of(Bytes& bytes, const ParameterSpec& spec, const Scene& scene) {
  using Type = ParameterSpec::Type;
  const bool place = spec.unit == "m" || spec.name.find("point") != std::string::npos;
  nlohmann::json list = nlohmann::json::array();
  switch (spec.type) {
    case Type::kInteger:
      return integer_of(bytes, spec);
    case Type::kIntegers: {
      std::set<std::uint64_t> values;  // increasing, as levels are
      for (std::uint32_t n = 1 + bytes.below(3); n > 0; --n) values.insert(integer_of(bytes, spec));
      return values;
    }
    case Type::kNumber:
      return number_of(bytes, spec, scene);
    case Type::kNumbers:
      return nlohmann::json::array({number_of(bytes, spec, scene)});
    case Type::kChoice:
      return spec.choices[bytes.below(static_cast<std::uint32_t>(spec.choices.size()))];
    case Type::kNames:
      return nlohmann::json::array({std::to_string(
          bytes.below(spec.name == "materials" ? scene.materials : std::min(scene.nodes, 200u)))});
    case Type::kText:
      return "fuzz";
    case Type::kColor:
      return "#8090a0";
    case Type::kVector:
    case Type::kDirection:
      return vector_of(bytes, spec, scene, place);
    case Type::kVectors: {
      const auto least = static_cast<std::uint32_t>(std::max<std::uint64_t>(spec.min, 1)),
                 most =
                     static_cast<std::uint32_t>(std::min<std::uint64_t>(spec.max, spec.max > 1000 ? 24 : 4));
      for (std::uint32_t n = least + bytes.below(std::max(most, least) - least + 1); n > 0; --n)
        list.push_back(vector_of(bytes, spec, scene, place || list.empty()));
      return list;
    }
    case Type::kMatrix:
      for (int r = 0; r < 3; ++r) {
        nlohmann::json row = nlohmann::json::array();
        for (int c = 0; c < 3; ++c) row.push_back((r == c ? 1 : 0) + bytes.between(-0.4, 0.4));
        list.push_back(row);
      }
      return list;
    case Type::kAssignments: {
      const auto presets = material_presets();
      for (std::uint32_t n = 1 + bytes.below(3); n > 0; --n)
        list.push_back({{"part", bytes.below(8)},
                        {"material", presets[bytes.below(static_cast<std::uint32_t>(presets.size()))].name}});
      return list;
    }
  }
  return {};
}

/// Parameters that the importer or an earlier answer determines.
const std::set<std::string> kNotDrawn{"format",        "of",   "broken", "fragment", "fragment_sites",
                                      "fragment_seed", "unit", "up"};

/// Parses the request after removing all members that the table refuses.
RequestParameters parse(const ParameterTable& table, nlohmann::json& request) {
  for (;;) {
    std::vector<RawParameter> given;
    for (const auto& [name, value] : request.items()) given.push_back({name, value, false});
    const Expected<RequestParameters> parsed = table.parse(given);
    if (parsed) return *parsed;
    const std::size_t before = request.size();
    for (const auto& one : parsed.error().extra->value("errors", nlohmann::json::array()))
      request.erase(one.value("parameter", ""));
    request.erase(parsed.error().pointer);
    if (request.size() == before) request = nlohmann::json::object();
  }
}

}  // namespace

FractureCase decode_case(const std::uint8_t* data, std::size_t size) {
  static const ParameterTable table(400, FormatSet::all());
  Bytes bytes(data, size);
  FractureCase result;
  std::vector<Vec3d> sites;
  result.mesh = mesh_of(bytes, result.shape, sites);
  const Box box = box_of(result.mesh);
  // Without a minimum thickness a sheet would have no volume.
  const double longest = std::max(box.longest_side(), 1e-100);
  double volume = 1;
  for (int a = 0; a < 3; ++a) volume *= std::max(box.size()[a], 1e-3 * longest);
  const Scene scene{box, longest, volume, static_cast<std::uint32_t>(result.mesh.node_names.size()),
                    static_cast<std::uint32_t>(result.mesh.library->materials.size())};

  nlohmann::json& request = result.request;
  request = nlohmann::json::object();
  request["sites"] = 1 + bytes.below(120);
  request["seed"] = bytes.byte();
  const std::uint32_t share = std::array{0, 2, 6, 24}[bytes.below(4)];  // of 64, for each parameter
  for (const ParameterSpec& spec : table.specs()) {
    if (kNotDrawn.contains(spec.name)) continue;
    const bool common = spec.name == "pattern" || spec.name == "material";
    if (bytes.below(64) < (common ? 20 : share)) request[spec.name] = value_of(bytes, spec, scene);
  }
  // Some parameters come in pairs.
  if (request.contains("local_point") != request.contains("local_radius"))
    for (const char* name : {"local_point", "local_radius"})
      if (!request.contains(name)) request[name] = value_of(bytes, *table.find(name), scene);
  if (request.contains("keep_center") != request.contains("keep_radius"))
    for (const char* name : {"keep_center", "keep_radius"})
      if (!request.contains(name)) request[name] = value_of(bytes, *table.find(name), scene);
  if (!sites.empty() && bytes.below(4) < 3) {  // the sites that belong to the family
    request["pattern"] = "points";
    nlohmann::json points = nlohmann::json::array();
    for (const Vec3d& p : sites)
      if (points.size() < 400) points.push_back({p.x, p.y, p.z});
    request["points"] = points;
  }
  result.has_refracture = bytes.once_in(12);
  result.refracture = bytes.below(256);
  result.parameters = parse(table, request);
  return result;
}

std::string to_obj(const Mesh& mesh) {
  std::string text;
  char line[120];
  for (const Vec3f& p : mesh.positions) {
    std::snprintf(line, sizeof line, "v %.9g %.9g %.9g\n", p.x, p.y, p.z);
    text += line;
  }
  for (const auto& t : mesh.triangles) {
    std::snprintf(line, sizeof line, "f %u %u %u\n", t[0] + 1, t[1] + 1, t[2] + 1);
    text += line;
  }
  return text;
}

}  // namespace fracture::fuzz
