// The report of an answer as text. Every figure has its name, the names are in order, and no figure appears
// that was not requested.
#include "common/gltf/report_text.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tests/gltf/two_halves.hpp"

namespace fracture::test {
namespace {

using nlohmann::json;

std::string text_of(const FracturedSolid& fractured) {
  JsonText text;
  write_report(text, fractured);
  return text.take();
}
json report_of(const FracturedSolid& fractured) { return json::parse(text_of(fractured)); }

/// Everything that can be requested, all together. No request does this, because `dual` and rough cuts
/// exclude each other.
FracturedSolid with_everything() {
  FracturedSolid made = two_halves();
  made.hierarchy.levels.resize(2);
  made.hierarchy.levels[0].clusters.resize(1);
  made.hierarchy.levels[1].clusters.resize(2);
  Report& report = made.report;
  report.solid = {};
  report.solid.welded = 12;
  report.solid.volume = 0.5;
  report.solid.add_sample("welded", {0, 1, 2});
  report.solid.add_sample("flipped", {0.5f, 0, 0});
  report.sites = {.given = 9, .used = 6, .duplicates_merged = 2, .far_dropped = 1};
  report.size.volumes = {1, 2, 3, 4, 5, 2.5, 0.25, 0.75};
  report.size.triangles = 24;
  report.size.limits = {.min_volume = 0.1, .max_fragments = 7, .max_triangles = 100};
  report.size.united = {.united = 3, .alone = 1, .min_volume = 0.1, .fewest_triangles = 20};
  report.size.max_volume = 6;
  report.size.split = {.sites_added = 4, .passes = 2, .too_large = 1};
  report.contacts = ContactReport{.gap = 0.5,
                                  .parts = 4,
                                  .alone = 1,
                                  .pairs = 2,
                                  .touching = 1,
                                  .overlapping = 1,
                                  .area = 5,
                                  .volume = 0.25};
  report.contacts->listed = {{.a = 1, .b = 2, .area = 4, .place = {1, 2, 3}, .normal = {0, 1, 0}},
                             {.a = 0,
                              .b = 2,
                              .kind = ContactKind::kOverlapping,
                              .area = 1,
                              .place = {},
                              .normal = {1, 0, 0},
                              .volume = 0.25}};
  report.kept = {5, 0.25};
  report.anchored = 1;
  report.hulls = {.hulls = 3, .flat = 2, .simplified = 1, .excess = 1.25};
  report.rough_cuts = {.amplitude = 0.01,
                       .amplitude_asked = 0.02,
                       .edge_length = 0.125,
                       .triangles = 40,
                       .calmed_vertices = 4,
                       .crossing_triangles = 1,
                       .restrained_cells = 2};
  report.barycenter = {.skipped_hulls = 2, .dropped = BarycenterReport::Dropped{3, 0.5}};
  report.fragment = {77, 0.25};
  report.frame = {0.0254, FrameReport::From::kRequest, true, FrameReport::From::kFile};
  report.passed_through = 11;
  report.remarks = {{"first", "second"}, {"a \"note\""}};
  report.dropped = {{"light", "Lamp", "fragments have no lights"}, {"animation", "2 more", "cut"}};
  report.choices = {{"unit", {{"unit", "mm"}}, "It is large."},
                    {"lid", {{"thickness", 0.02}}, "It is open."}};
  made.support = {.asked = {.gravity = {0, -10, 0}, .density = 500, .strength = 200, .broken = {7, 8}},
                  .falling = {1},
                  .loads = {{.tension = 1, .shear = 2, .bending = 3, .torsion = 4, .stress = 300}},
                  .weak = {0},
                  .anchored = 1,
                  .unknown = 1,
                  .residual = 0.5};
  return made;
}

TEST(ReportText, EachFigureStandsUnderItsName) {
  const json report = report_of(with_everything());
  EXPECT_EQ(report.at("anchors"), json::parse(R"({"fragments": 1})"));
  EXPECT_EQ(report.at("barycenter"), json::parse(R"({"partition": false, "skipped_hulls": 2, "dropped": 3,
                                                    "dropped_volume": 0.5})"));
  EXPECT_EQ(report.at("choices"),
            json::parse(R"([{"kind": "unit", "parameters": {"unit": "mm"}, "text": "It is large."},
                            {"kind": "lid", "parameters": {"thickness": 0.02}, "text": "It is open."}])"));
  EXPECT_EQ(choices_document(with_everything().report.choices), report.at("choices"));
  EXPECT_EQ(choices_document({}), json::array());
  EXPECT_EQ(
      report.at("contacts"),
      json::parse(
          R"({"alone": 1, "area": 5, "gap": 0.5, "overlapping": 1, "pairs": 2, "parts": 4, "touching": 1,
                            "volume": 0.25,
                            "listed": {"a": [1, 0], "b": [2, 2], "kind": ["touching", "overlapping"], "area": [4, 1],
                                       "place": [[1, 2, 3], [0, 0, 0]], "normal": [[0, 1, 0], [1, 0, 0]],
                                       "volume": [0, 0.25]}})"));
  EXPECT_EQ(report.at("dropped"),
            json::parse(R"([{"what": "light", "name": "Lamp", "reason": "fragments have no lights"},
                            {"what": "animation", "name": "2 more", "reason": "cut"}])"));
  EXPECT_EQ(dropped_document(with_everything().report.dropped), report.at("dropped"));
  EXPECT_EQ(report.at("fragment"), json::parse(R"({"id": 77, "volume": 0.25})"));
  EXPECT_EQ(report.at("frame"), json::parse(R"({"metres_per_unit": 0.0254, "unit_from": "request", "up": "z",
                                                "up_from": "file"})"));
  FracturedSolid far = with_everything();
  far.report.frame->offset = {500000, 30, 4649776};
  EXPECT_EQ(report_of(far).at("frame").at("offset"), json({500000.0, 30.0, 4649776.0}));
  EXPECT_EQ(report.at("hulls"), json::parse(R"({"count": 3, "flat": 2, "simplified": 1, "excess": 1.25})"));
  EXPECT_EQ(report.at("keep"), json::parse(R"({"cells": 5, "share": 0.25})"));
  EXPECT_EQ(report.at("levels"), json({1, 2, 2})) << "two clusters, two fragments";
  EXPECT_EQ(report.at("passed_through"), json::parse(R"({"triangles": 11})"));
  EXPECT_EQ(report.at("rough_cuts"),
            json::parse(R"({"amplitude": 0.01, "amplitude_asked": 0.02, "edge_length": 0.125, "triangles": 40,
                            "calmed_vertices": 4, "crossing_triangles": 1, "restrained_cells": 2})"));
  EXPECT_EQ(report.at("sites"),
            json::parse(R"({"given": 9, "used": 6, "duplicates_merged": 2, "far_dropped": 1})"));
  EXPECT_EQ(report.at("size"),
            json::parse(R"({"smallest": 1, "lowest_tenth": 2, "median": 3, "highest_tenth": 4, "largest": 5,
                            "mean": 2.5, "coefficient_of_variation": 0.25, "share_of_largest_tenth": 0.75,
                            "triangles": 24, "united": 3, "alone": 1, "min_volume": 0.1, "max_fragments": 7,
                            "max_triangles": 100, "fewest_triangles": 20, "max_volume": 6, "sites_added": 4,
                            "passes": 2, "too_large": 1})"));
  EXPECT_EQ(report.at("warnings"), json({"first", "second"}));
  EXPECT_EQ(report.at("notes"), json::array({"a \"note\""}));
}

TEST(ReportText, SupportNamesFragmentsByIdAndBondsInTheirOrder) {
  EXPECT_EQ(report_of(with_everything()).at("support"),
            json::parse(R"({"gravity": [0, -10, 0], "density": 500, "strength": 200, "broken": [7, 8],
                            "anchored": 1, "unknown": 1, "residual": 0.5, "falling": [7],
                            "weak": {"a": [9007199254740991], "b": [7], "stress": [300], "share": [1.5]},
                            "bonds": {"tension": [1], "shear": [2], "bending": [3], "torsion": [4],
                                      "stress": [300]}})"));
  // If the strength is zero or too small to divide by, the share is null.
  for (const double strength : {0.0, 1e-310}) {
    FracturedSolid weak = with_everything();
    weak.support->asked.strength = strength;
    EXPECT_TRUE(report_of(weak).at("support").at("weak").at("share").at(0).is_null()) << strength;
  }
}

TEST(ReportText, TheSolidIsAsItsOwnReportHasIt) {
  const FracturedSolid made = with_everything();
  const json solid = report_of(made).at("solid");
  EXPECT_EQ(solid, made.report.solid.to_json());
  EXPECT_EQ(solid.size(), 25u);
  EXPECT_EQ(solid.at("welded"), 12);
  EXPECT_FALSE(solid.contains("notes")) << "sentences are in the report alone";
  EXPECT_EQ(solid.at("samples"), json::parse(R"({"welded": [0, 1, 2], "flipped": [0.5, 0, 0]})"));
}

TEST(ReportText, NamesStandInTheirOrder) {
  for (const FracturedSolid& made : {two_halves(), with_everything()}) {
    const std::string text = text_of(made);
    JsonText sorted;  // the library sorts members by name
    sorted.value(json::parse(text));
    EXPECT_EQ(text, sorted.text());
  }
}

TEST(ReportText, WhatWasNotAskedForIsNotThere) {
  const json report = report_of(two_halves());
  EXPECT_EQ(report.size(), 5u);
  for (const char* name : {"notes", "sites", "size", "solid", "warnings"})
    EXPECT_TRUE(report.contains(name)) << name;
  EXPECT_EQ(report.at("size").size(), 9u) << "the volumes and the number of triangles";
}

TEST(ReportText, TheCertificateHasItsNumbersAsTheyStandInTheFile) {
  Certificate certificate;
  certificate.volume_in = 2;  // not 2.0
  certificate.relative_error = 1e-17;
  certificate.fragments = 3;
  const json document = certificate_document(certificate);
  EXPECT_EQ(document.size(), 18u);
  EXPECT_EQ(document.at("volume_in").dump(), "2");
  EXPECT_EQ(document.at("relative_error").get<double>(), 1e-17);
  EXPECT_EQ(document.at("fragments"), 3);
}

}  // namespace
}  // namespace fracture::test
