// Requests that cannot fit into the working memory are refused before they are computed, with the parameter to change.
#include <gtest/gtest.h>

#include "server/service/estimate.hpp"
#include "server/service/service.hpp"
#include "tests/server/service/hits_fixture.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

RequestParameters with_sites(std::uint32_t sites, double amplitude = 0) {
  RequestParameters asked;
  asked.fracture.sites = sites;
  asked.fracture.roughness.amplitude = amplitude;
  asked.fracture.roughness.octaves = 4;
  return asked;
}

TEST(EstimateRefusal, NamesWhatCostsMost) {
  const Solid cube = solid_of(test::cube()), sphere = solid_of(sphere_with(100'000));
  const RequestParameters rough = with_sites(30, 0.05), many = with_sites(20'000), few = with_sites(3);
  const auto half_of = [](const RequestParameters& asked, const Solid& solid) {
    return static_cast<std::uint64_t>(expected_answer(asked, solid).working_bytes / 2.1);
  };
  EXPECT_EQ(costliest_parameter(rough, cube, 1e6).name, "rough_amplitude");
  EXPECT_EQ(costliest_parameter(many, cube, 1e6).name, "sites");
  EXPECT_EQ(costliest_parameter(few, sphere, 1e6).name, "");

  const auto refused = cannot_fit(rough, cube, half_of(rough, cube));
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code, ErrorCode::kTooComplex);
  EXPECT_EQ(refused->pointer, "rough_amplitude");
  EXPECT_NE(refused->detail.find("rough_amplitude=0"), std::string::npos) << refused->detail;
  EXPECT_EQ(refused->detail.find("and with it"), std::string::npos) << "this is enough: " << refused->detail;

  // The advice is followed: what it proposes fits.
  const std::uint64_t limit = half_of(many, cube);
  const CostliestParameter fewer = costliest_parameter(many, cube, static_cast<double>(limit));
  ASSERT_TRUE(fewer.value.is_number_integer());
  EXPECT_LE(expected_answer(with_sites(fewer.value.get<std::uint32_t>()), cube).working_bytes,
            static_cast<double>(limit));
  EXPECT_GT(fewer.value.get<std::uint32_t>(), 20'000u / 4);

  const auto of_the_mesh = cannot_fit(few, sphere, half_of(few, sphere));
  ASSERT_TRUE(of_the_mesh);
  EXPECT_NE(of_the_mesh->detail.find("send a mesh with fewer"), std::string::npos) << of_the_mesh->detail;
  EXPECT_FALSE(cannot_fit(many, cube, 1ull << 32));
}

TEST(EstimateRefusal, CountsFragmentsIfTheyWereAskedFor) {
  const Solid cube = solid_of(test::cube());
  RequestParameters asked = with_sites(10'000);
  asked.fracture.size.fragments = 10'000;
  EXPECT_EQ(costliest_parameter(asked, cube, 1e6).name, "fragments");
  asked.fracture.size.fragments = 0;
  GridPattern grid;
  grid.cell = Vec3d{0.02, 0.02, 0.02};
  asked.fracture.pattern = grid;
  EXPECT_EQ(costliest_parameter(asked, cube, 1e6).name, "cell");
  asked.fracture.pattern = UniformPattern{};
  asked.fracture.max_volume = 1e-5;
  EXPECT_EQ(costliest_parameter(asked, cube, 1e6).name, "max_volume");
}

TEST(EstimateRefusal, ComesBeforeTheDiagramAndTheCut) {
  const std::string mesh = box_obj(4);
  FractureService service({}, engine_in_process());
  FractureRequest request;
  request.mesh = bytes(mesh);
  request.format = MeshFormat::kObj;
  request.parameters = with_sites(300, 0.05);
  Allowance allowance(0, 8u << 20, [](std::uint64_t wanted) {
    return wanted <= (8u << 20) ? Allowance::Answer::kGranted : Allowance::Answer::kNever;
  });
  Execution execution;
  execution.allowance = &allowance;
  const auto refused = service.fracture(request, execution);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kTooComplex);
  EXPECT_NE(refused.error().detail.find("rough_amplitude=0"), std::string::npos) << refused.error().detail;
  EXPECT_EQ(refused.error().extra->at("estimated"), true);
  EXPECT_EQ(allowance.made(Product::kTetrahedra), 0u);
  EXPECT_EQ(allowance.made(Product::kPolygons), 0u);
}

// An estimate that is too low does not refuse. The computation then ends when its memory does, with the same advice.
TEST(EstimateRefusal, ALateRefusalHasTheSameAdvice) {
  const Solid cube = solid_of(test::cube());
  const RequestParameters rough = with_sites(30, 0.05);
  Error late{ErrorCode::kTooComplex,
             std::string("It needs 5 bytes; the limit is 4. ") + kAdviceForFewerProducts};
  late.extra = fracture::Figures(nlohmann::json{{"grew", "cap_triangles"}, {"limit", 1u << 20}});
  const Error advised = with_advice(late, rough, cube, "--memory");
  EXPECT_TRUE(advised.detail.starts_with(
      "It needs 5 bytes; the limit is 4. Most of the memory is for 'rough_amplitude': use rough_amplitude=0 (about "))
      << advised.detail;
  EXPECT_TRUE(advised.detail.ends_with(", or raise --memory.")) << advised.detail;
  EXPECT_EQ(advised.detail.find(kAdviceForFewerProducts), std::string::npos);
  const Error other{ErrorCode::kTooComplex, "20 sites are requested; at most 10 are allowed."};
  EXPECT_EQ(with_advice(other, rough, cube).detail, other.detail);
}

TEST(EstimateRefusal, TheDocumentSaysWhetherItFits) {
  const Solid cube = solid_of(test::cube());
  const RequestParameters asked = with_sites(1000);
  const nlohmann::json fits = estimate_document(asked, cube, 1u << 30),
                       no_limit = estimate_document(asked, cube, 0),
                       too_much = estimate_document(asked, cube, 1u << 20);
  EXPECT_EQ(fits.at("fits"), true);
  EXPECT_EQ(fits.at("costliest"), "sites");
  EXPECT_TRUE(fits.at("advice").is_null());
  EXPECT_TRUE(no_limit.at("limit_bytes").is_null());
  EXPECT_EQ(no_limit.at("fits"), true);
  EXPECT_EQ(too_much.at("fits"), false);
  EXPECT_TRUE(too_much.at("advice").is_string());
}

// Between once and twice the limit, the request may be refused while it runs.
TEST(EstimateRefusal, TheDocumentGivesAdviceWheneverTheEstimateIsAboveTheLimit) {
  const Solid cube = solid_of(test::cube());
  const RequestParameters asked = with_sites(1000);
  const auto needed = static_cast<std::uint64_t>(expected_answer(asked, cube).working_bytes);
  const nlohmann::json above = estimate_document(asked, cube, needed * 2 / 3),
                       within = estimate_document(asked, cube, needed * 3 / 2);
  EXPECT_EQ(above.at("fits"), true) << "it is not refused at once";
  ASSERT_TRUE(above.at("advice").is_string());
  const auto advice = above.at("advice").get<std::string>();
  EXPECT_NE(advice.find("--max-working"), std::string::npos) << advice;
  EXPECT_NE(advice.find("use sites="), std::string::npos) << advice;
  EXPECT_TRUE(within.at("advice").is_null());
}

}  // namespace
}  // namespace fracture::test
