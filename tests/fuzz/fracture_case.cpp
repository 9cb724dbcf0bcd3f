#include "tests/fuzz/fracture_case.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "common/mesh/material_library.hpp"
#include "tests/fuzz/case_mesh.hpp"

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
