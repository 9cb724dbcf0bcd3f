#include "common/gltf/report_text.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

namespace fracture {
namespace {

void write_frame(JsonText& json, const FrameReport& frame) {
  json.key("frame").begin_object().member("metres_per_unit", frame.metres_per_unit);
  if (!(frame.offset == Vec3d{})) json.member("offset", frame.offset);
  json.member("unit_from", name_of(frame.unit_from))
      .member("up", frame.z_up ? "z" : "y")
      .member("up_from", name_of(frame.up_from))
      .end_object();
}

void write_barycenter(JsonText& json, const BarycenterReport& barycenter) {
  json.key("barycenter").begin_object();
  if (barycenter.dropped)
    json.member("dropped", barycenter.dropped->fragments)
        .member("dropped_volume", barycenter.dropped->volume);
  json.member("partition", false).member("skipped_hulls", barycenter.skipped_hulls).end_object();
}

void write_dropped(JsonText& json, const std::vector<Dropped>& dropped) {
  json.begin_array();
  for (const Dropped& entry : dropped)
    json.begin_object()
        .member("name", entry.name)
        .member("reason", entry.reason)
        .member("what", entry.what)
        .end_object();
  json.end_array();
}

void write_choices(JsonText& json, const std::vector<Choice>& choices) {
  json.begin_array();
  for (const Choice& choice : choices) {
    json.begin_object().member("kind", choice.kind).key("parameters").begin_object();
    for (const Choice::Setting& setting : choice.parameters)
      std::visit([&](const auto& value) { json.member(setting.name, value); }, setting.value);
    json.end_object().member("text", choice.text).end_object();
  }
  json.end_array();
}

void write_rough_cuts(JsonText& json, const RoughCuts& cuts) {
  json.key("rough_cuts")
      .begin_object()
      .member("amplitude", cuts.amplitude)
      .member("amplitude_asked", cuts.amplitude_asked)
      .member("calmed_vertices", cuts.calmed_vertices)
      .member("crossing_triangles", cuts.crossing_triangles)
      .member("edge_length", cuts.edge_length);
  if (cuts.restrained_cells > 0) json.member("restrained_cells", cuts.restrained_cells);
  json.member("triangles", cuts.triangles).end_object();
}

/// Members are in alphabetical order, so limits and their effects are listed among the volumes.
void write_size(JsonText& json, const SizeReport& size) {
  const SizeLimits& limits = size.limits;
  const VolumeDistribution& volumes = size.volumes;
  const bool split = size.max_volume > 0;
  json.key("size").begin_object();
  if (limits.any()) json.member("alone", size.united.alone);
  json.member("coefficient_of_variation", volumes.coefficient_of_variation);
  if (limits.max_triangles > 0) json.member("fewest_triangles", size.united.fewest_triangles);
  if (limits.fragments > 0) json.member("fragments", limits.fragments);
  json.member("highest_tenth", volumes.highest_tenth)
      .member("largest", volumes.largest)
      .member("lowest_tenth", volumes.lowest_tenth);
  if (limits.max_fragments > 0) json.member("max_fragments", limits.max_fragments);
  if (limits.max_triangles > 0) json.member("max_triangles", limits.max_triangles);
  if (split) json.member("max_volume", size.max_volume);
  json.member("mean", volumes.mean).member("median", volumes.median);
  if (limits.any() && size.united.min_volume > 0) json.member("min_volume", size.united.min_volume);
  if (limits.fragments > 0) json.member("parts", size.united.parts);
  if (split) json.member("passes", size.split.passes);
  json.member("share_of_largest_tenth", volumes.share_of_largest_tenth);
  if (split) json.member("sites_added", size.split.sites_added);
  json.member("smallest", volumes.smallest);
  if (split) json.member("too_large", size.split.too_large);
  json.member("triangles", size.triangles);
  if (limits.any()) json.member("united", size.united.united);
  json.end_object();
}

/// Writes the listed contacts as columns.
void write_contacts(JsonText& json, const ContactReport& contacts) {
  const auto column = [&](const char* name, const auto& of) {
    json.key(name).begin_array();
    for (const Contact& contact : contacts.listed) json.value(of(contact));
    json.end_array();
  };
  json.begin_object()
      .member("alone", contacts.alone)
      .member("area", contacts.area)
      .member("gap", contacts.gap);
  json.key("listed").begin_object();
  column("a", [](const Contact& c) { return c.a; });
  column("area", [](const Contact& c) { return c.area; });
  column("b", [](const Contact& c) { return c.b; });
  column("kind",
         [](const Contact& c) { return c.kind == ContactKind::kOverlapping ? "overlapping" : "touching"; });
  column("normal", [](const Contact& c) { return c.normal; });
  column("place", [](const Contact& c) { return c.place; });
  column("volume", [](const Contact& c) { return c.volume; });
  json.end_object()
      .member("overlapping", contacts.overlapping)
      .member("pairs", contacts.pairs)
      .member("parts", contacts.parts)
      .member("touching", contacts.touching)
      .member("volume", contacts.volume)
      .end_object();
}

void write_solid(JsonText& json, const SolidReport& solid) {
  json.key("solid").begin_object();
  solid.each_figure([&](const char* name, const auto& figure) {
    json.key(name);
    if constexpr (std::is_same_v<decltype(figure), const std::vector<SolidReport::Sample>&>) {
      std::vector<const SolidReport::Sample*> samples;
      for (const SolidReport::Sample& sample : figure) samples.push_back(&sample);
      std::sort(samples.begin(), samples.end(),
                [](const auto* a, const auto* b) { return a->figure < b->figure; });
      json.begin_object();
      for (const SolidReport::Sample* sample : samples) json.member(sample->figure, sample->place);
      json.end_object();
    } else {
      json.value(figure);
    }
  });
  json.end_object();
}

void write_rest(JsonText& json, const RestFigures& rest) {
  json.begin_object()
      .member("pairs", rest.pairs)
      .member("trimmed", rest.trimmed)
      .member("filtered", rest.filtered)
      .member("left", rest.left)
      .member("deepest", rest.deepest)
      .member("tolerance", rest.tolerance)
      .member("least_share", rest.least_share)
      .member("systems", rest.systems)
      .end_object();
}

/// Writes only the members of the object.
void write_proof(JsonText& json, const Certificate& c) {
  json.member("open_edges", c.open_edges)
      .member("volume_in", c.volume_in)
      .member("volume_once", c.volume_once)
      .member("volume_out", c.volume_out)
      .member("volume_file", c.volume_file)
      .member("relative_error", c.relative_error)
      .member("pocket_volume", c.pocket_volume)
      .member("pocket_area", c.pocket_area)
      .member("unmirrored_caps", c.unmirrored_caps)
      .member("area_in", c.area_in)
      .member("area_out", c.area_out);
  if (c.sheet_area_in > 0)
    json.member("sheet_area_in", c.sheet_area_in).member("sheet_area_out", c.sheet_area_out);
  json.member("sites_asked", c.sites_asked)
      .member("cells", c.cells)
      .member("islands", c.islands)
      .member("united", c.united)
      .member("dropped", c.dropped)
      .member("fragments", c.fragments)
      .member("crossing_caps", c.crossing_caps);
}

}  // namespace

void write_report(JsonText& json, const FracturedSolid& fractured) {
  const Report& report = fractured.report;
  json.begin_object();
  if (report.anchored) json.key("anchors").begin_object().member("fragments", *report.anchored).end_object();
  if (report.barycenter) write_barycenter(json, *report.barycenter);
  if (!report.choices.empty()) {
    json.key("choices");
    write_choices(json, report.choices);
  }
  if (report.contacts) {
    json.key("contacts");
    write_contacts(json, *report.contacts);
  }
  if (!report.dropped.empty()) {
    json.key("dropped");
    write_dropped(json, report.dropped);
  }
  if (report.fragment)
    json.key("fragment")
        .begin_object()
        .member("id", report.fragment->id)
        .member("volume", report.fragment->volume)
        .end_object();
  if (report.frame) write_frame(json, *report.frame);
  if (report.hulls)
    json.key("hulls")
        .begin_object()
        .member("count", report.hulls->hulls)
        .member("excess", report.hulls->excess)
        .member("flat", report.hulls->flat)
        .member("simplified", report.hulls->simplified)
        .end_object();
  if (report.instances)
    json.key("instances")
        .begin_object()
        .member("fragments", report.instances->fragments)
        .member("shapes", report.instances->shapes)
        .end_object();
  if (report.kept)
    json.key("keep")
        .begin_object()
        .member("cells", report.kept->cells)
        .member("share", report.kept->share)
        .end_object();
  if (const auto& levels = fractured.hierarchy.levels; !levels.empty()) {
    json.key("levels").begin_array();
    for (const ClusterLevel& level : levels) json.value(level.clusters.size());
    json.value(fractured.set.fragments.size()).end_array();
  }
  json.member("notes", report.remarks.notes);
  if (report.passed_through)
    json.key("passed_through").begin_object().member("triangles", *report.passed_through).end_object();
  if (report.rough_cuts) write_rough_cuts(json, *report.rough_cuts);
  json.key("sites")
      .begin_object()
      .member("duplicates_merged", report.sites.duplicates_merged)
      .member("far_dropped", report.sites.far_dropped)
      .member("given", report.sites.given)
      .member("used", report.sites.used)
      .end_object();
  write_size(json, report.size);
  write_solid(json, report.solid);
  if (fractured.support) {
    json.key("support");
    write_support(json, fractured.set, *fractured.support);
  }
  json.member("warnings", report.remarks.warnings).end_object();
}

void write_support(JsonText& json, const FragmentSet& set, const Support& support) {
  const SupportOptions& asked = support.asked;
  const auto column = [&](const char* name, const auto& of, const auto& write) {
    json.key(name).begin_array();
    for (const auto& each : of) write(each);
    json.end_array();
  };
  const auto loads = [&](const char* name, double BondLoad::*figure) {
    column(name, support.loads, [&](const BondLoad& load) { json.value(load.*figure); });
  };
  const auto id = [&](std::uint32_t fragment) { json.value(set.fragments[fragment].id); };
  const auto stress = [&](std::uint32_t bond) { return support.loads[bond].stress; };

  json.begin_object().member("anchored", support.anchored);
  json.key("bonds").begin_object();
  loads("bending", &BondLoad::bending);
  loads("shear", &BondLoad::shear);
  loads("stress", &BondLoad::stress);
  loads("tension", &BondLoad::tension);
  loads("torsion", &BondLoad::torsion);
  json.end_object();
  column("broken", asked.broken, [&](std::uint64_t gone) { json.value(gone); });
  json.member("density", asked.density);
  column("falling", support.falling, id);
  json.member("gravity", asked.gravity)
      .member("residual", support.residual)
      .member("strength", asked.strength)
      .member("unknown", support.unknown);
  json.key("weak").begin_object();
  column("a", support.weak, [&](std::uint32_t bond) { id(set.bonds[bond].a); });
  column("b", support.weak, [&](std::uint32_t bond) { id(set.bonds[bond].b); });
  column("share", support.weak, [&](std::uint32_t bond) {
    // Not finite if the strength is 0, or too small to divide by.
    if (const double share = stress(bond) / (asked.strength * set.bonds[bond].strength); std::isfinite(share))
      json.value(share);
    else
      json.null();
  });
  column("stress", support.weak, [&](std::uint32_t bond) { json.value(stress(bond)); });
  json.end_object().end_object();
}

void write_certificate(JsonText& json, const Certificate& certificate, const std::optional<Rest>& rest) {
  json.begin_object();
  write_proof(json, certificate);
  json.key("rest");
  if (rest)
    write_rest(json, rest->figures);
  else
    json.null();
  json.end_object();
}

nlohmann::json choices_document(const std::vector<Choice>& choices) {
  JsonText json;
  write_choices(json, choices);
  return nlohmann::json::parse(json.text());
}

nlohmann::json dropped_document(const std::vector<Dropped>& dropped) {
  JsonText json;
  write_dropped(json, dropped);
  return nlohmann::json::parse(json.text());
}

nlohmann::json contacts_document(const ContactReport& contacts) {
  JsonText json;
  write_contacts(json, contacts);
  return nlohmann::json::parse(json.text());
}

nlohmann::json certificate_document(const Certificate& certificate) {
  JsonText json;
  json.begin_object();
  write_proof(json, certificate);
  json.end_object();
  return nlohmann::json::parse(json.text());
}

}  // namespace fracture
