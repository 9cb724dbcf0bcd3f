// The lines and the summary of `inspect` for many meshes.
#include "server/cli/inspect_list.hpp"

#include <gtest/gtest.h>

#include "common/base/exit_codes.hpp"

namespace fracture::cli {
namespace {

using nlohmann::json;

json report(const std::string& input, const char* verdict = "closed") {
  return {{"input", input},
          {"verdict", verdict},
          {"size", {2.0, 0.5, 1.25}},
          {"solid", {{"parts", 1}, {"open_edges", 0}, {"shells_dropped", 0}}},
          {"warnings", json::array()},
          {"choices", json::array()}};
}

TEST(InspectLine, StatesVerdictSizePartsAndOverlaps) {
  EXPECT_EQ(line_of(report("a.obj")), "a.obj: closed; 2 x 0.5 x 1.25 m; 1 part; no overlaps; drops nothing");
  json several = report("b.obj", "repaired");
  several["solid"]["parts"] = 1200;
  several["contacts"] = {{"overlapping", 3}};
  several["warnings"] = {"One.", "Two."};
  several["choices"] = {{{"kind", "lid"}}};
  EXPECT_EQ(
      line_of(several),
      "b.obj: repaired; 2 x 0.5 x 1.25 m; 1,200 parts; 3 overlaps; drops nothing; 2 warnings; 1 choice");
}

TEST(InspectLine, CountsLossesByKind) {
  json lossy = report("a.glb");
  lossy["solid"]["shells_dropped"] = 4;
  lossy["dropped"] = {{{"what", "light"}, {"name", "Sun"}},
                      {{"what", "camera"}, {"name", "Main"}},
                      {{"what", "light"}, {"name", "Lamp"}}};
  EXPECT_EQ(
      line_of(lossy),
      "a.glb: closed; 2 x 0.5 x 1.25 m; 1 part; no overlaps; drops light (2), camera (1), thin piece without "
      "volume (4)");
}

TEST(InspectLine, SaysWhyThereIsNoReportAndEscapesNames) {
  EXPECT_EQ(line_of({{"input", "a\n.obj"},
                     {"verdict", "refused"},
                     {"error", "mesh-not-closed"},
                     {"detail", "It is open."}}),
            "a\\x0a.obj: refused: mesh-not-closed: It is open.");
  EXPECT_EQ(line_of({{"input", "a.obj"}, {"verdict", "unreadable"}, {"detail", "No such file"}}),
            "a.obj: unreadable: No such file");
}

TEST(InspectSummary, NamesTheFilesOfEachCause) {
  InspectSummary summary;
  EXPECT_EQ(summary.exit_code(), kExitDone);
  summary.add(report("closed.obj"), kExitDone);
  EXPECT_EQ(summary.exit_code(), kExitDone);
  for (const char* name : {"a.obj", "b.obj", "c.obj", "d.obj", "e.obj"}) {
    json open = report(name, "repaired");
    open["solid"]["open_edges"] = 4;
    if (*name == 'b') open["solid"]["flipped"] = 1;
    summary.add(open, kExitRepaired);
  }
  EXPECT_EQ(summary.exit_code(), kExitRepaired);
  summary.add({{"input", "f.obj"}, {"verdict", "refused"}, {"error", "empty-mesh"}, {"detail", "None."}},
              kExitRefused);
  EXPECT_EQ(summary.exit_code(), kExitRefused);
  summary.add_dangling("props");
  EXPECT_EQ(summary.exit_code(), kExitSystem);
  EXPECT_EQ(summary.lines(),
            (std::vector<std::string>{"8 files: 1 closed, 5 repaired, 1 refused, 1 unreadable",
                                      "  unreadable: the link's target does not exist: 1 (props)",
                                      "  refused: empty-mesh: 1 (f.obj)",
                                      "  repaired: open edges: 5 (a.obj, b.obj, c.obj, and 2 more)",
                                      "  repaired: triangles that faced inwards: 1 (b.obj)"}));
  const json document = summary.document();
  EXPECT_EQ(document.at("files"), 8);
  EXPECT_EQ(document.at("repaired"), 5);
  EXPECT_EQ(document.at("causes").size(), 4u);
  EXPECT_EQ(document.at("causes")[2].at("kind"), "repaired");
  EXPECT_EQ(document.at("causes")[2].at("inputs").size(), 5u);
}

}  // namespace
}  // namespace fracture::cli
