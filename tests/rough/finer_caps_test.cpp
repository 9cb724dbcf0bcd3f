// Pieces with finer caps, derived from pieces with flat caps: a search from scratch must find the same.
#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/fragment/pieces.hpp"
#include "common/rough/roughen.hpp"
#include "common/sites/sites.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

template <class T>
T made(Expected<T> expected) {
  if (!expected) throw std::runtime_error(expected.error().detail);
  return std::move(*expected);
}

/// A solid cut by 60 sites, with all objects that refer to each other. Every `together` consecutive sites
/// stay together.
struct Cut {
  Cut(const Mesh& mesh, std::uint32_t together)
      : solid(made(make_solid(std::make_shared<Mesh>(mesh), {}, {}))),
        t(made(tetrahedralize(made(uniform_sites(solid, 60, 7, {})), solid.box, {}))),
        diagram(t, solid.box),
        restricted(restrict_to_solid(SeenSolid(solid), diagram, {})) {
    std::vector<std::uint32_t> groups;
    for (std::uint32_t s = 0; s < t.site_count(); ++s) groups.push_back(s / together);
    ownership = Ownership::from_groups(t.site_count(), groups);
  }

  Solid solid;
  Tetrahedralization t;
  VoronoiDiagram diagram;
  RestrictedDiagram restricted;
  Ownership ownership;
};

/// Keeps the vertices that flat caps also have. Vertices in between, from rough caps, belong to no cell.
std::vector<std::vector<CutVertexId>> of_flat(std::vector<std::vector<CutVertexId>> bodies,
                                              std::size_t vertices) {
  for (std::vector<CutVertexId>& body : bodies)
    std::erase_if(body, [&](CutVertexId v) { return v >= vertices; });
  return bodies;
}

class FinerCaps : public testing::TestWithParam<std::uint32_t> {
 protected:
  /// Returns the number of pieces, or 0 if they must be found from scratch.
  static std::size_t compare(const Mesh& mesh, double amplitude = 0.02) {
    Cut cut(mesh, GetParam());
    const Execution execution;
    const Pieces flat = gather_pieces(cut.restricted, cut.ownership, execution);
    const std::size_t vertices = cut.restricted.vertex_count();
    roughen(cut.restricted, cut.ownership.owner_of_site, {amplitude, 5, 2}, {}, 1, execution);
    EXPECT_GT(cut.restricted.vertex_count(), vertices);
    const std::optional<Pieces> finer = with_finer_caps(flat, cut.restricted, execution);
    if (!finer) return 0;
    const Pieces found = gather_pieces(cut.restricted, cut.ownership, execution);
    EXPECT_EQ(finer->piece_of_cap, found.piece_of_cap);
    EXPECT_EQ(finer->pieces.size(), found.pieces.size());
    for (std::size_t k = 0; k < std::min(finer->pieces.size(), found.pieces.size()); ++k) {
      const Piece &a = finer->pieces[k], &b = found.pieces[k];
      EXPECT_EQ(a.owners, b.owners);
      EXPECT_EQ(a.part, b.part);
      EXPECT_EQ(a.island, b.island);
      EXPECT_EQ(of_flat(a.bodies, vertices), of_flat(b.bodies, vertices));
      EXPECT_EQ(a.faces.size(), b.faces.size());
      for (std::size_t f = 0; f < std::min(a.faces.size(), b.faces.size()); ++f) {
        EXPECT_EQ(a.faces[f].source, b.faces[f].source);
        EXPECT_EQ(a.faces[f].v, b.faces[f].v);
      }
    }
    return found.pieces.size();
  }
};

TEST_P(FinerCaps, AreThoseThatAreFoundAnew) {
  EXPECT_GT(compare(sphere_with(500)), 0u);
  EXPECT_GT(compare(torus(32, 16)), 0u);
  EXPECT_GT(compare(menger_sponge(2)), 0u);
  EXPECT_GT(compare(thin_plate(0.02)), 0u);
}

TEST_P(FinerCaps, OfManyPartsIslandsAndCavities) {
  EXPECT_GT(compare(cube_field(3)), 0u);
  EXPECT_GT(compare(nested_spheres(3, 200)), 0u);
  EXPECT_GT(compare(joined({cube(), reversed(scaled(cube(), {0.2, 0.2, 0.2}))})), 0u);
}

TEST_P(FinerCaps, WhereASurfaceCrossesItselfEitherThatOrNothing) {
  compare(self_crossing_tube());
  compare(klein_bottle());
}

INSTANTIATE_TEST_SUITE_P(CellsTogether, FinerCaps, testing::Values(1u, 4u));

}  // namespace
}  // namespace fracture::test
