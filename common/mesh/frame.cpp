#include "common/mesh/frame.hpp"

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

namespace fracture {

double metres_of(LengthUnit unit) {
  switch (unit) {
    case LengthUnit::kCentimetre:
      return 0.01;
    case LengthUnit::kMillimetre:
      return 0.001;
    case LengthUnit::kInch:
      return 0.0254;
    case LengthUnit::kKilometre:
      return 1000;
    default:
      return 1;
  }
}

namespace {

/// (x, y, z) -> (x, z, -y). Subtracting from zero keeps zeros positive, so equal coordinates stay equal bit
/// for bit.
template <class Vector>
void turn(Vector& v) {
  const auto y = v.y;
  v.y = v.z;
  v.z = 0 - y;
}

/// The shortest digits that read back as the same double, without the locale.
std::string written(double value) {
  char text[350];  // the largest double has 309 digits
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::fixed).ptr;
  return {text, end};
}

/// Turns the node like the positions, and its own axes with it: what stands upright on its z axis stands on its y axis
/// afterwards.
void turn_axes(EmptyNode& node) {
  const auto turned = [](const Vec3d& v) { return Vec3d{v.x, v.z, 0.0 - v.y}; };
  const Vec3d y = turned(node.z), z = -1.0 * turned(node.y);
  node.x = turned(node.x);
  node.y = y;
  node.z = z;
  node.t = turned(node.t);
}

}  // namespace

const char* name_of(FrameReport::From from) {
  switch (from) {
    case FrameReport::From::kRequest:
      return "request";
    case FrameReport::From::kFile:
      return "file";
    default:
      return "assumed";
  }
}

void to_json(nlohmann::json& document, const FrameReport& frame) {
  document = {{"metres_per_unit", frame.metres_per_unit},
              {"unit_from", name_of(frame.unit_from)},
              {"up", frame.z_up ? "z" : "y"},
              {"up_from", name_of(frame.up_from)}};
  if (!(frame.offset == Vec3d{})) document["offset"] = {frame.offset.x, frame.offset.y, frame.offset.z};
}

std::string to_text(const Vec3d& place) {
  return "(" + written(place.x) + ", " + written(place.y) + ", " + written(place.z) + ")";
}

Expected<FrameReport> to_metres_y_up(Mesh& mesh, const FrameOptions& options) {
  const bool unit_asked = options.unit != LengthUnit::kFromFile, up_asked = options.up != UpAxis::kFromFile;
  const double metres = unit_asked ? metres_of(options.unit) : mesh.frame.metres;
  const bool z_up = up_asked ? options.up == UpAxis::kZ : mesh.frame.z_up;

  if (metres != 1)
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      Vec3f& p = mesh.positions[v];
      p = {static_cast<float>(p.x * metres), static_cast<float>(p.y * metres),
           static_cast<float>(p.z * metres)};
      if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
        return fail(ErrorCode::kNotFinite,
                    "Vertex " + std::to_string(v) + " is too far from the origin (one unit of the file is " +
                        std::to_string(metres) + " m).",
                    "unit", {{"vertex", v}});
    }
  for (EmptyNode& node : mesh.empty_nodes) {
    node.t = metres * node.t;
    if (z_up) turn_axes(node);
  }
  Vec3d offset = metres * mesh.frame.offset;
  if (z_up) {
    turn(offset);
    for (Vec3f& p : mesh.positions) turn(p);
    for (Vec3f& n : mesh.attributes.normals) turn(n);
    for (Vec4f& t : mesh.attributes.tangents) turn(t);
  }
  for (MeshInstance& instance : mesh.instances)
    for (Vec3d* v : {&instance.x, &instance.y, &instance.z, &instance.t}) {
      if (metres != 1) *v = metres * *v;
      if (z_up) turn(*v);
    }
  using From = FrameReport::From;
  const auto from = [](bool asked, bool stated) {
    return asked ? From::kRequest : stated ? From::kFile : From::kAssumed;
  };
  const FrameReport report{.metres_per_unit = metres,
                           .unit_from = from(unit_asked, mesh.frame.metres_stated),
                           .z_up = z_up,
                           .up_from = from(up_asked, mesh.frame.up_stated),
                           .offset = offset};
  mesh.frame = {
      .metres = 1, .metres_stated = true, .z_up = false, .up_stated = true, .offset = report.offset};
  if (!(offset == Vec3d{}))
    mesh.remarks.note(
        "The mesh is so far from its origin that floats are too coarse there. Therefore, the answer's root node is at " +
        to_text(offset) +
        " m, and all places in the answer and its report are relative to this point. Places in parameters "
        "are still measured from the file's origin.");
  return report;
}

}  // namespace fracture
