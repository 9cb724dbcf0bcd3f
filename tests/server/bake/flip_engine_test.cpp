// The engine with the source paper's insertion gives the same diagrams and the same files as the usual
// engine, for each solid.
#include "server/bake/flip_engine.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>
#include <stop_token>
#include <vector>

#include "tests/server/support/engine_in_process.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::bake {
namespace {

struct Case {
  const char* name;
  Mesh mesh;
};

std::vector<std::uint8_t> file_of(const FractureEngine& engine, const Solid& solid, const CutBase& base,
                                  const FractureParameters& parameters) {
  const Expected<Cut> cut = engine.cut(solid, base, parameters, {}, {});
  if (!cut) throw std::runtime_error(cut.error().detail);
  return engine.encode(cut->fractured, {}, OutputFormat::kGlb, {}).bytes;
}

TEST(FlipEngine, GivesTheSameDiagramsAndFilesAsTheCavity) {
  const Case cases[] = {{"cube", test::cube()},
                        {"sphere", test::sphere_with(2000)},
                        {"torus", test::torus(32, 16)},
                        {"sponge", test::menger_sponge(1)},
                        {"nested spheres", test::nested_spheres(3, 200)}};
  const auto tally = std::make_shared<FlipTally>();
  const std::unique_ptr<FractureEngine> cavity = test::engine_in_process(),
                                        flips = flip_engine(test::engine_in_process(), tally);
  std::size_t input = 0;
  for (const Case& c : cases) {
    ++input;
    std::size_t turn = 0;
    const Expected<Solid> solid = cavity->prepare(std::make_shared<Mesh>(c.mesh), {}, {}, {});
    ASSERT_TRUE(solid) << c.name;
    for (const std::uint32_t sites : {1u, 2u, 50u, 400u})
      for (const bool shaped : {false, true}) {
        if (!test::has_turn(input, turn++, 4)) continue;
        SCOPED_TRACE(std::string(c.name) + ", " + std::to_string(sites) + (shaped ? " shaped" : ""));
        FractureParameters p;
        p.sites = sites;
        p.seed = 3 * sites;
        if (shaped) {
          p.lloyd = 1;
          p.anisotropy.stretch = 3;
        }
        const Expected<CutBase> a = cavity->base(*solid, p, {}, {}), b = flips->base(*solid, p, {}, {});
        ASSERT_TRUE(a && b);
        const Diagram &ours = std::get<Diagram>(*a), &theirs = std::get<Diagram>(*b);
        EXPECT_EQ(theirs.sites, ours.sites);
        const Tetrahedralization &s = ours.tetrahedralization, &t = theirs.tetrahedralization;
        EXPECT_EQ(t.points, s.points);
        EXPECT_EQ(t.site_of_input, s.site_of_input);
        EXPECT_EQ(t.tet_of_site, s.tet_of_site);
        ASSERT_EQ(t.tets.size(), s.tets.size());
        for (std::size_t k = 0; k < s.tets.size(); ++k) {
          ASSERT_EQ(t.tets[k].v, s.tets[k].v);
          ASSERT_EQ(t.tets[k].n, s.tets[k].n);
        }
        EXPECT_TRUE(file_of(*flips, *solid, *b, p) == file_of(*cavity, *solid, *a, p));
      }
  }
  const FlipCounts counts = tally->counts();
  EXPECT_GT(counts.flip14, 0u);
  EXPECT_GT(counts.flip23, 0u);
  EXPECT_GT(counts.flip32, 0u);
  EXPECT_EQ(counts.flip41, 0u) << "nothing is removed";
}

TEST(FlipEngine, StopsWhenItIsToldTo) {
  const std::unique_ptr<FractureEngine> flips =
      flip_engine(test::engine_in_process(), std::make_shared<FlipTally>());
  const Expected<Solid> solid = flips->prepare(std::make_shared<Mesh>(test::cube()), {}, {}, {});
  std::stop_source stop;
  stop.request_stop();
  Execution execution;
  execution.stop = stop.get_token();
  const Expected<CutBase> made = flips->base(*solid, {}, {}, execution);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::kCancelled);
}

}  // namespace
}  // namespace fracture::bake
