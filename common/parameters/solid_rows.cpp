// The rows that determine the solid: repairs, sheets, walls, the frame and the selected parts of the mesh.
#include <utility>

#include "common/parameters/fields.hpp"
#include "common/parameters/rows.hpp"
#include "common/parameters/values.hpp"

namespace fracture {

using parameter_fields::with_member;

std::vector<ParameterSpec> solid_parameter_rows() {
  std::vector<ParameterSpec> rows;
  const auto add = [&](ParameterSpec spec) {
    spec.decides = Decides::kSolid;
    rows.push_back(std::move(spec));
  };
  add(with_member(
      {.name = "repair",
       .type = Type::kChoice,
       .choices = {"fill", "strict"},
       .doc =
           "Treatment of an open or inconsistently oriented mesh. `fill`: holes are closed and inverted surfaces are "
           "flipped. `strict`: the mesh is refused."},
      [](auto& r) -> auto& { return r.solid.repair; }));
  ParameterSpec sheets = with_member(
      {.name = "sheets",
       .type = Type::kChoice,
       .choices = {"attach", "whole", "solid", "drop"},
       .doc =
           "Treatment of sheets, which are surfaces that enclose no volume (panes, leaves, decals). `attach`: the "
           "solid's cells cut the sheets, and each fragment carries its pieces of sheets on a child node. `whole`: "
           "sheets stay whole, on separate nodes. `solid`: sheets become slabs (see `thickness`). `drop`: sheets are "
           "left out."},
      [](auto& r) -> auto& { return r.solid.sheets; });
  // With a thickness, sheets are slabs anyway.
  sheets.matters = [](const RequestParameters& r) {
    return r.solid.sheets != SheetsMode::kAttach && r.solid.thickness == 0;
  };
  add(std::move(sheets));
  add(with_member(
      {.name = "thickness",
       .type = Type::kNumber,
       .unit = "m",
       .low = 0,
       .high = 1000,
       .doc =
           "Open sheets become slabs of this thickness, as with `sheets=solid`. Rooms, and pieces with a large opening "
           "(cloth, terrain), become walls of this thickness. Other open pieces become solid, with a warning, if a slab "
           "would have less volume. 0: with `sheets=solid`, slabs are 1/500 of the mesh's diagonal thick."},
      [](auto& r) -> auto& { return r.solid.thickness; }));
  ParameterSpec shell = with_member(
      {.name = "shell",
       .type = Type::kNumber,
       .unit = "m",
       .low = 0,
       .high = 1000,
       .doc =
           "Wall thickness. Closed parts without a cavity become hollow if they are more than twice as thick as this. "
           "Use it for vessels modelled as solids. 0: use `shell_fraction`. If you give 0, a material adds no walls."},
      [](auto& r) -> auto& { return r.hollow.thickness; });
  shell.set = [](RequestParameters& r, const ParameterSpec&, const ParameterValue& value) {
    r.hollow = {.thickness = std::get<double>(value)};  // replaces the walls of a material
  };
  shell.matters = [](const RequestParameters& r) { return r.hollow.thickness > 0; };
  add(std::move(shell));
  ParameterSpec fraction = with_member(
      {.name = "shell_fraction",
       .type = Type::kNumber,
       .low = 0,
       .high = 0.5,
       .doc =
           "Wall thickness as a fraction of the longest side of each part's bounding box. Defaults with a material: glass "
           "0.02, ceramic 0.04, terracotta 0.06, metal 0.015."},
      [](auto& r) -> auto& { return r.hollow.fraction; });
  fraction.set = [](RequestParameters& r, const ParameterSpec&, const ParameterValue& value) {
    r.hollow.fraction = std::get<double>(value);
    r.hollow.least_ball = 0;
  };
  // 0 is kept if the material has walls, because a client may send an answer's parameters again.
  fraction.matters = [](const RequestParameters& r) {
    const MaterialPreset* preset = find_material_preset(r.material);
    return r.hollow.fraction > 0 || (preset && preset->shell_fraction > 0);
  };
  add(std::move(fraction));
  ParameterSpec ball = with_member(
      {.name = "shell_ball",
       .type = Type::kNumber,
       .low = 0,
       .high = 1,
       .doc =
           "A part becomes hollow only if a ball of this diameter fits into it, so plates, rods and parts with walls "
           "stay as they are. The diameter is a fraction of the longest side of the part's box: 0, or at least 0.1. 0: "
           "all parts. Default: 0.2 if the material has walls, otherwise 0."},
      [](auto& r) -> auto& { return r.hollow.least_ball; });
  ball.check = [](const ParameterValue& value) -> std::optional<std::string> {
    const double given = std::get<double>(value);
    if (given == 0 || given >= kSmallestBall) return std::nullopt;
    return "be 0 or at least " + shortest(kSmallestBall);
  };
  ball.matters = [](const RequestParameters& r) { return r.hollow.any() && r.hollow.least_ball > 0; };
  add(std::move(ball));
  add(with_member(
      {.name = "weld_tolerance",
       .type = Type::kNumber,
       .low = 0,
       .high = 0.01,
       .doc =
           "Vertices closer together than this fraction of the bounding box's diagonal are merged if that closes open "
           "edges. 0: only vertices at the same position."},
      [](auto& r) -> auto& { return r.solid.weld_tolerance; }));
  add(with_member(
      {.name = "contact_gap",
       .type = Type::kNumber,
       .unit = "m",
       .low = 0,
       .high = 1000,
       .doc =
           "Parts (closed surfaces) are in contact if they overlap or are within this distance of each other. Their "
           "fragments are bonded. Default: 0.001 times the longest side of the mesh's box. Values above 0.1 times this "
           "side have no further effect."},
      [](auto& r) -> auto& { return r.solid.contact_gap; }));
  add(with_member(
      {.name = "unit",
       .type = Type::kChoice,
       .choices = {"file", "m", "cm", "mm", "inch", "km"},
       .doc =
           "Unit of the mesh's coordinates. `file`: the unit of the file or its format, or metres if neither has one."},
      [](auto& r) -> auto& { return r.frame.unit; }));
  add(with_member(
      {.name = "up",
       .type = Type::kChoice,
       .choices = {"file", "y", "z"},
       .doc =
           "Axis of the mesh that points up. `file`: the axis of the file or its format, or y if neither has one."},
      [](auto& r) -> auto& { return r.frame.up; }));
  add(with_member(
      {.name = "nodes",
       .type = Type::kNames,
       .doc =
           "Break only these nodes (comma-separated names, patterns such as `Wall_*`, or indices) and all nodes below them. "
           "Other nodes stay whole."},
      [](auto& r) -> auto& { return r.parts.nodes; }));
  add(with_member(
      {.name = "materials",
       .type = Type::kNames,
       .doc =
           "Break only triangles with these materials (comma-separated names, patterns such as `Glass*`, or indices). Other "
           "triangles stay whole."},
      [](auto& r) -> auto& { return r.parts.materials; }));
  ParameterSpec proxies = with_member(
      {.name = "proxies",
       .type = Type::kChoice,
       .choices = {"hulls", "geometry"},
       .doc =
           "Treatment of nodes whose names mark them as levels of detail or collision geometry. `hulls`: if the mesh "
           "has a node `Crate_LOD0`, levels such as `Crate_LOD1` are left out. Collision geometry (`UCX_Crate_00`, "
           "`Crate-col`) becomes colliders of the unbroken mesh (`intact=true`). `geometry`: all nodes are broken."},
      [](auto& r) -> auto& { return r.proxies; });
  proxies.matters = [](const RequestParameters& r) { return r.proxies != Proxies::kHulls; };
  add(std::move(proxies));
  return rows;
}

}  // namespace fracture
