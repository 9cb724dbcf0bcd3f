// A mesh at survey coordinates gives the answer of the same mesh near the origin, below a root node at its offset.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "server/service/mesh_report.hpp"
#include "tests/gltf/glb_file.hpp"
#include "tests/import/make_files.hpp"
#include "tests/server/service/hits_fixture.hpp"

namespace fracture::test {
namespace {

const Vec3d kFar{500000, 30, 4649776};

/// The tetrahedron below a root at this place.
std::string tetrahedron_at(const Vec3d& place) {
  Tetrahedron tet;
  tet.json["nodes"] = {{{"translation", {place.x, place.y, place.z}}, {"children", {1}}},
                       {{"mesh", 0}, {"name", "tet"}}};
  return tet.glb();
}

json at(const Vec3d& offset, double x, double y, double z) {
  return json::array({offset.x + x, offset.y + y, offset.z + z});
}

class FarMesh {
 public:
  explicit FarMesh(std::string mesh) : service_({}, engine_in_process()), mesh_(std::move(mesh)) {}

  Expected<FractureAnswer> answer(const json& parameters) {
    return service_.fracture(request(parameters), {});
  }
  Glb glb(const json& parameters) {
    auto made = answer(parameters);
    if (!made) throw std::runtime_error(made.error().detail);
    return Glb(made->result->file);
  }
  json report() { return mesh_report(*service_.prepare(request(json::object()), {}).value()); }

 private:
  FractureRequest request(const json& parameters) {
    std::vector<RawParameter> given;
    for (const auto& [name, value] : parameters.items()) given.push_back({name, value, false});
    FractureRequest request;
    request.mesh = bytes(mesh_);
    request.format = MeshFormat::kGlb;
    request.parameters = service_.parameters().parse(given).value();
    return request;
  }

  FractureService service_;
  std::string mesh_;
};

const json& root_of(const Glb& glb) { return glb.document["nodes"][0]; }
const json& figures_in(const Glb& glb) { return root_of(glb)["extras"]["fracture"]; }

TEST(FarMesh, GivesTheAnswerOfItsTwinBelowARootAtTheOffset) {
  FarMesh near(tetrahedron_at({})), far(tetrahedron_at(kFar));
  // All numbers are sums of few powers of two, so they are exact at both places.
  const auto requests = [](const Vec3d& o) {
    return std::vector<json>{
        {{"sites", 6}, {"intact", "true"}},
        {{"pattern", "points"},
         {"points", {at(o, .125, .125, .125), at(o, .5, .125, .125), at(o, .125, .5, .25)}}},
        {{"sites", 8},
         {"pattern", "impact"},
         {"impacts", json::array({at(o, .25, .25, .25)})},
         {"radius", 0.25}},
        {{"sites", 4},
         {"local_point", json::array({at(o, .125, .125, .125)})},
         {"local_radius", json::array({0.25})},
         {"local_sites", json::array({5})},
         {"anchor_plane", {at(o, 0, .0625, 0), {0, 1, 0}}}},
        {{"sites", 8}, {"keep_center", at(o, .125, .125, .125)}, {"keep_radius", 0.125}},
        {{"sites", 8},
         {"keep_box", {at(o, 0, 0, 0), at(o, .25, .25, .25)}},
         {"anchor_points", json::array({at(o, .25, .125, .125)})}}};
  };
  const std::vector<json> near_requests = requests({}), far_requests = requests(kFar);
  for (std::size_t k = 0; k < near_requests.size(); ++k) {
    const Glb here = near.glb(near_requests[k]), there = far.glb(far_requests[k]);
    EXPECT_EQ(there.binary, here.binary) << near_requests[k];
    EXPECT_FALSE(root_of(here).contains("translation"));
    EXPECT_EQ(root_of(there).at("translation"), at(kFar, 0, 0, 0));
    ASSERT_EQ(there.document["nodes"].size(), here.document["nodes"].size());
    for (std::size_t n = 1; n < here.document["nodes"].size(); ++n) {
      json node = there.document["nodes"][n];
      if (node.value("name", "") == "Intact") {
        EXPECT_EQ(node.at("translation"), at(kFar, 0, 0, 0));
        node.erase("translation");
        node["extras"] = here.document["nodes"][n]["extras"];  // it states the digest of the file
      }
      EXPECT_EQ(node, here.document["nodes"][n]) << "below the root, all is the same";
    }
    EXPECT_EQ(figures_in(there).at("bonds"), figures_in(here).at("bonds"));
    EXPECT_EQ(figures_in(there).at("certificate"), figures_in(here).at("certificate"));
    EXPECT_EQ(figures_in(there).at("report").at("frame").at("offset"), at(kFar, 0, 0, 0));
    EXPECT_FALSE(figures_in(here).at("report").at("frame").contains("offset"));
  }
}

TEST(FarMesh, IsReportedWithItsOffset) {
  const json report = FarMesh(tetrahedron_at(kFar)).report();
  EXPECT_EQ(report.at("frame").at("offset"), at(kFar, 0, 0, 0));
  const auto notes = report.at("notes").get<std::vector<std::string>>();
  EXPECT_TRUE(std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
    return note.find("(500000, 30, 4649776)") != note.npos;
  }));
}

TEST(FarMesh, PlacesInMessagesAreThoseOfTheRequest) {
  FarMesh far(tetrahedron_at(kFar));
  // 1 m to the left of the corner (0, 0, 0), which is the nearest place.
  const Glb glb =
      far.glb({{"sites", 4}, {"pattern", "impact"}, {"impacts", json::array({at(kFar, -1, 0, 0)})}});
  const auto warnings = figures_in(glb).at("report").at("warnings").get<std::vector<std::string>>();
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("499999,30,4649776"), std::string::npos) << warnings[0];
  EXPECT_NE(warnings[0].find("500000,30,4649776"), std::string::npos) << warnings[0];

  const auto refused =
      far.answer({{"sites", 4}, {"pattern", "impact"}, {"impacts", json::array({at({}, 0, 0, 0)})}});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kBadParameter);
  EXPECT_EQ(refused.error().pointer, "impacts");
}

// An answer for a far mesh, as input, has an offset again. The box may be a little smaller, so the offset may be the next multiple.
TEST(FarMesh, AnAnswerCanBeBrokenAgain) {
  FarMesh far(tetrahedron_at(kFar));
  const auto answer = far.answer({{"sites", 6}});
  ASSERT_TRUE(answer);
  const std::vector<std::uint8_t>& file = answer->result->file;
  FarMesh again(std::string(file.begin(), file.end()));
  const json report = again.report();
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(report.at("frame").at("offset").at(static_cast<std::size_t>(axis)).get<double>(), kFar[axis],
                2);
  EXPECT_NEAR(report.at("solid").at("volume").get<double>(), 1.0 / 6, 1e-6);
}

}  // namespace
}  // namespace fracture::test
