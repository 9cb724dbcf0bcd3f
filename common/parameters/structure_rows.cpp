// Rows for sizes, levels, kept regions, anchors, and fragments that break again.
#include <algorithm>
#include <utility>

#include "common/parameters/fields.hpp"
#include "common/parameters/rows.hpp"

namespace fracture {
namespace {

using parameter_fields::kFar;
using parameter_fields::kFarPlace;
using parameter_fields::kLeastLength;
using parameter_fields::with_member;

constexpr std::uint32_t kMostLevels = 8;

nlohmann::json vectors(const std::vector<Vec3d>& list) {
  nlohmann::json json = nlohmann::json::array();
  for (const Vec3d& v : list) json.push_back({v.x, v.y, v.z});
  return json;
}

/// Makes the rows from `first` on matter only if `matters` returns true.
void only_where(std::vector<ParameterSpec>& rows, std::size_t first,
                const std::function<bool(const RequestParameters&)>& matters) {
  for (; first < rows.size(); ++first) rows[first].matters = matters;
}

ParameterSpec fragments_row(std::uint32_t max_sites) {
  ParameterSpec spec = with_member(
      {.name = "fragments",
       .type = Type::kInteger,
       .min = 0,
       .max = max_sites,
       .doc =
           "Number of fragments. If the result differs by more than a tenth, a warning says why. Parts that touch "
           "no other part share this number in proportion to their volume; each gets at least one. Parts closer to "
           "`impacts` get more. "
           "Without `sites`, the pattern makes as many cells as needed. 0: `sites` determines the number. Not with "
           "`levels` or `dual=barycenter`."},
      [](auto& r) -> auto& { return r.fracture.size.fragments; });
  spec.decides = Decides::kSites;  // patterns that divide the box make as many cells as this number requires
  spec.matters = [](const RequestParameters& r) { return r.fracture.size.fragments > 0; };
  return spec;
}

ParameterSpec parts_row() {
  ParameterSpec spec = with_member(
      {.name = "parts",
       .type = Type::kChoice,
       .choices = {"together", "apart"},
       .doc =
           "How parts that overlap or touch become fragments. `together`: their pieces in the same cell form one "
           "fragment. A part too small to be a fragment joins the part with which it has the largest contact. `apart`: "
           "every fragment belongs to one part."},
      [](auto& r) -> auto& { return r.fracture.parts; });
  spec.matters = [](const RequestParameters& r) { return r.fracture.parts != Parts::kTogether; };
  return spec;
}

ParameterSpec instances_row() {
  ParameterSpec spec = with_member(
      {.name = "instances",
       .type = Type::kChoice,
       .choices = {"keep", "separate"},
       .doc =
           "How to break instances: nodes of a glTF file that share a mesh and differ only by rotation, translation and "
           "uniform scale. `keep`: an instance no larger than the mean fragment stays whole unless it is joined to "
           "other parts. Whole instances share one copy of their mesh in the answer. `separate`: instances are treated "
           "like other parts. `parts=apart`, `pivot=source` and `dual=barycenter` also have this effect."},
      [](auto& r) -> auto& { return r.fracture.instances; });
  spec.matters = [](const RequestParameters& r) { return r.fracture.instances != InstanceUse::kKeep; };
  return spec;
}

void add_size_rows(std::vector<ParameterSpec>& rows, std::uint32_t max_sites) {
  rows.push_back(fragments_row(max_sites));
  rows.push_back(parts_row());
  rows.push_back(instances_row());
  const auto size = [&](const char* name, double most, const char* unit, const char* doc, auto member) {
    rows.push_back(with_member(
        {.name = name, .type = Type::kNumber, .unit = unit, .low = 0, .high = most, .doc = doc}, member));
    rows.back().matters = [member](const RequestParameters& r) { return member(r) > 0; };
  };
  size(
      "min_volume", 1e18, "m³",
      "A fragment smaller than this is merged with the neighbour that shares the largest area with it. The largest of "
      "`min_volume`, `min_fraction` and `min_of_mean` applies.",
      [](auto& r) -> auto& { return r.fracture.size.min_volume; });
  size(
      "min_fraction", 1, "", "Like `min_volume`, but as a fraction of the solid's volume.",
      [](auto& r) -> auto& { return r.fracture.size.min_fraction; });
  size(
      "min_of_mean", 1, "",
      "Like `min_volume`, but as a fraction of the fragments' mean volume, to avoid crumbs. Near a hit, the limit is a "
      "hundredth of this value. Default with a `material`: 0.002.",
      [](auto& r) -> auto& { return r.fracture.size.min_of_mean; });
  // With a material, 0 differs from the value that the material sets.
  rows.back().matters = [](const RequestParameters& r) {
    return r.fracture.size.min_of_mean > 0 || !r.material.empty();
  };
  size(
      "max_volume", 1e18, "m³",
      "If a cell contains a piece larger than this, the cell gets more sites, which divide the piece. 0: no limit. Not "
      "with `radial`, `grid`, `brick` or `slice`.",
      [](auto& r) -> auto& { return r.fracture.max_volume; });
  rows.back().decides = Decides::kSites;
  rows.push_back(with_member(
      {.name = "max_fragments",
       .type = Type::kInteger,
       .min = 0,
       .max = 1'000'000,
       .doc = "The smallest fragments are merged until at most this many are left. 0: no limit."},
      [](auto& r) -> auto& { return r.fracture.size.max_fragments; }));
  rows.back().matters = [](const RequestParameters& r) { return r.fracture.size.max_fragments > 0; };
  rows.push_back(with_member(
      {.name = "max_triangles",
       .type = Type::kInteger,
       .min = 0,
       .max = 1'000'000'000,
       .doc =
           "The smallest fragments are merged until all fragments together have at most this many triangles. 0: no limit."},
      [](auto& r) -> auto& { return r.fracture.size.max_triangles; }));
  rows.back().matters = [](const RequestParameters& r) { return r.fracture.size.max_triangles > 0; };
}

ParameterSpec levels_row(std::uint32_t max_sites) {
  ParameterSpec spec{
      .name = "levels",
      .type = Type::kIntegers,
      .min = 1,
      .max = max_sites,
      .doc =
          "Number of pieces in each of up to eight levels of a hierarchy, coarsest first. The last number replaces `sites`. "
          "The pieces of the coarser levels are clusters of fragments."};
  spec.patterns = patterns_that(&PatternTraits::counted);
  spec.check = [](const ParameterValue& value) -> std::optional<std::string> {
    const auto& levels = std::get<std::vector<std::uint64_t>>(value);
    const bool increasing =
        std::adjacent_find(levels.begin(), levels.end(), std::greater_equal<>()) == levels.end();
    if (increasing && levels.size() <= kMostLevels) return std::nullopt;
    return "be 1 to " + std::to_string(kMostLevels) + " numbers, each larger than the one before";
  };
  spec.set = [](RequestParameters& r, const ParameterSpec&, const ParameterValue& value) {
    const auto& levels = std::get<std::vector<std::uint64_t>>(value);
    r.fracture.levels.assign(levels.begin(), levels.end() - 1);
    r.fracture.sites = static_cast<std::uint32_t>(levels.back());
  };
  spec.get = [](const RequestParameters& r, const ParameterSpec&) {
    if (r.fracture.levels.empty()) return nlohmann::json();
    nlohmann::json levels = r.fracture.levels;
    levels.push_back(r.fracture.sites);
    return levels;
  };
  return spec;
}

/// Returns the two corners of a box, lowest and highest.
ParameterSpec box_row(const char* name, const char* doc) {
  ParameterSpec spec{.name = name,
                     .type = Type::kVectors,
                     .unit = "m",
                     .min = 2,
                     .max = 2,
                     .low = -kFarPlace,
                     .high = kFarPlace,
                     .doc = doc};
  spec.check = [](const ParameterValue& value) -> std::optional<std::string> {
    const auto& corners = std::get<std::vector<Vec3d>>(value);
    for (int a = 0; a < 3; ++a)
      if (corners[0][a] > corners[1][a]) return "be the lowest and the highest corner, in that order";
    return std::nullopt;
  };
  return spec;
}

void add_keep_rows(std::vector<ParameterSpec>& rows) {
  const std::size_t first = rows.size();
  rows.push_back(with_member(
      {.name = "keep_center",
       .type = Type::kVector,
       .unit = "m",
       .low = -kFarPlace,
       .high = kFarPlace,
       .doc =
           "Centre of a sphere in which nothing is cut. Its surface becomes a cut with 92 flat facets. Requires "
           "`keep_radius`."},
      [](auto& r) -> auto& { return r.keep_center; }));
  rows.push_back(with_member(
      {.name = "keep_radius",
       .type = Type::kNumber,
       .unit = "m",
       .low = kLeastLength,
       .high = kFar,
       .doc = "Radius of the sphere around `keep_center`."},
      [](auto& r) -> auto& { return r.keep_radius; }));
  ParameterSpec box = box_row(
      "keep_box",
      "Lowest and highest corners of a box in which nothing is cut, instead of a sphere. The sides of the box are flat "
      "cuts.");
  box.set = [](RequestParameters& r, const ParameterSpec&, const ParameterValue& value) {
    const auto& corners = std::get<std::vector<Vec3d>>(value);
    r.fracture.keep = Region{.shape = Region::Shape::kBox, .box = {corners[0], corners[1]}};
  };
  box.get = [](const RequestParameters& r, const ParameterSpec&) {
    if (!r.fracture.keep || r.fracture.keep->shape != Region::Shape::kBox) return nlohmann::json();
    return vectors({r.fracture.keep->box.min, r.fracture.keep->box.max});
  };
  rows.push_back(std::move(box));
  for (std::size_t k = first; k < rows.size(); ++k) rows[k].decides = Decides::kSites;
}

void add_anchor_rows(std::vector<ParameterSpec>& rows) {
  ParameterSpec plane{
      .name = "anchor_plane",
      .type = Type::kVectors,
      .min = 2,
      .max = 2,
      .low = -kFarPlace,
      .high = kFarPlace,
      .doc =
          "A point on a plane, and the plane's normal. Fragments that touch the plane or extend behind it are anchored. "
          "`0,0,0;0,1,0` is the ground at height 0."};
  plane.check = [](const ParameterValue& value) -> std::optional<std::string> {
    if (length(std::get<std::vector<Vec3d>>(value)[1]) > 1e-9) return std::nullopt;
    return "have a normal other than 0,0,0";
  };
  plane.set = [](RequestParameters& r, const ParameterSpec&, const ParameterValue& value) {
    const auto& given = std::get<std::vector<Vec3d>>(value);
    r.fracture.anchors.planes = {{given[1], dot(given[0], given[1]) / length(given[1]), given[0]}};
  };
  plane.get = [](const RequestParameters& r, const ParameterSpec&) {
    if (r.fracture.anchors.planes.empty()) return nlohmann::json();
    return vectors({r.fracture.anchors.planes[0].point, r.fracture.anchors.planes[0].normal});
  };
  rows.push_back(std::move(plane));
  ParameterSpec box = box_row(
      "anchor_box", "Lowest and highest corners of a box. Fragments that overlap the box are anchored.");
  box.set = [](RequestParameters& r, const ParameterSpec&, const ParameterValue& value) {
    const auto& corners = std::get<std::vector<Vec3d>>(value);
    r.fracture.anchors.boxes = {{corners[0], corners[1]}};
  };
  box.get = [](const RequestParameters& r, const ParameterSpec&) {
    if (r.fracture.anchors.boxes.empty()) return nlohmann::json();
    return vectors({r.fracture.anchors.boxes[0].min, r.fracture.anchors.boxes[0].max});
  };
  rows.push_back(std::move(box));
  rows.push_back(with_member(
      {.name = "anchor_points",
       .type = Type::kVectors,
       .unit = "m",
       .min = 1,
       .max = 1000,
       .low = -kFarPlace,
       .high = kFarPlace,
       .doc = "Fragments that contain or touch one of these points are anchored."},
      [](auto& r) -> auto& { return r.fracture.anchors.points; }));
  const std::size_t support = rows.size();
  rows.push_back(with_member(
      {.name = "gravity",
       .type = Type::kVector,
       .unit = "m/s²",
       .low = -1000,
       .high = 1000,
       .doc = "Gravitational acceleration for `report.support`."},
      [](auto& r) -> auto& { return r.gravity; }));
  rows.push_back(with_member(
      {.name = "broken",
       .type = Type::kIntegers,
       .min = 0,
       .max = kMaxSeed,
       .doc = "IDs of missing fragments. `report.support` shows what falls without them. Requires anchors."},
      [](auto& r) -> auto& { return r.broken; }));
  only_where(rows, support, [](const RequestParameters& r) { return r.fracture.anchors.any(); });
}

void add_again_rows(std::vector<ParameterSpec>& rows) {
  const std::size_t first = rows.size();
  rows.push_back(with_member(
      {.name = "fragment",
       .type = Type::kInteger,
       .min = 0,
       .max = kMaxSeed,
       .doc =
           "ID of a fragment to break again, from the answer to the same request without `fragment`. The new answer "
           "contains only the pieces of this fragment."},
      [](auto& r) -> auto& { return r.fragment; }));
  rows.push_back(with_member(
      {.name = "fragment_sites",
       .type = Type::kInteger,
       .min = 1,
       .max = 10'000,
       .doc = "Number of sites in `fragment`."},
      [](auto& r) -> auto& { return r.fragment_sites; }));
  rows.push_back(with_member(
      {.name = "fragment_seed",
       .type = Type::kInteger,
       .min = 0,
       .max = kMaxSeed,
       .doc = "Seed for the sites in `fragment`."},
      [](auto& r) -> auto& { return r.fragment_seed; }));
  only_where(rows, first, [](const RequestParameters& r) { return r.fragment.has_value(); });
}

}  // namespace

std::vector<ParameterSpec> structure_parameter_rows(std::uint32_t max_sites) {
  std::vector<ParameterSpec> rows{levels_row(max_sites)};
  add_size_rows(rows, max_sites);
  add_keep_rows(rows);
  add_anchor_rows(rows);
  for (ParameterSpec& row : hit_parameter_rows()) rows.push_back(std::move(row));
  add_again_rows(rows);
  return rows;
}

void drop_aggregation(RequestParameters& r) {
  // Like is_barycentric(), but hits may be incomplete.
  const bool whole = !r.local_point.empty() && r.fracture.rest == LocalRest::kWhole;
  if (r.fracture.dual != Dual::kBarycenter || whole || r.idle_aggregation) return;
  r.idle_aggregation = std::exchange(r.fracture.aggregation, {});
}

std::optional<Error> complete_structure(RequestParameters& r) {
  FractureParameters& f = r.fracture;
  if (std::optional<Error> wrong = complete_hits(r)) return wrong;
  if (!r.of.empty()) return std::nullopt;  // missing parameters may be in that answer
  if (r.keep_center.has_value() != r.keep_radius.has_value())
    return bad_parameter(
        r.keep_center ? "keep_radius" : "keep_center",
        r.keep_center ? "'keep_center' requires 'keep_radius': the radius of the kept sphere, in metres."
                      : "'keep_radius' requires 'keep_center': the centre of the kept sphere, in metres.");
  if (r.keep_center && f.keep)
    return bad_parameter(
        "keep_box",
        "'keep_box' and 'keep_center' were both given, but only one region can be kept. Leave one of them out.");
  if (r.keep_center) f.keep = Region{.center = *r.keep_center, .radius = *r.keep_radius};
  r.selection.refracture.reset();
  if (r.fragment) r.selection.refracture = Refracture{*r.fragment, r.fragment_sites, r.fragment_seed};
  if (!r.broken.empty() && !f.anchors.any())
    return bad_parameter(
        "broken",
        "'broken' requires anchors, because everything falls without them. Give 'anchor_plane', "
        "'anchor_box' or 'anchor_points'.");
  drop_aggregation(r);
  if (f.drop_above > 0 && f.dual != Dual::kBarycenter)
    return bad_parameter(
        "drop_above",
        "'drop_above' requires dual=barycenter, because an exact partition leaves nothing out. Use "
        "'max_volume' to break large fragments further.");
  if (f.max_volume > 0 && f.size.min_volume > f.max_volume)
    return bad_parameter("max_volume", "'max_volume' must be at least 'min_volume', which is " +
                                           nlohmann::json(f.size.min_volume).dump() + ".");
  return std::nullopt;
}

}  // namespace fracture
