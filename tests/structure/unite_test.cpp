// Many pieces that become one fragment: the tables that this uses, and its cost.
#include "common/fragment/unite.hpp"
#include "common/fragment/file_volume.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "common/base/random.hpp"
#include "common/clip/restricted_diagram.hpp"
#include "common/fragment/assemble.hpp"
#include "common/fragment/group_contacts.hpp"
#include "common/fragment/make_fragments.hpp"
#include "common/fragment/volume_sign.hpp"
#include "common/sites/sites.hpp"
#include "tests/support/growth_families.hpp"
#include "tests/support/poll_gaps.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

const Execution kAlone{};  // outlives the objects that refer to it

/// A solid cut by sites. It keeps everything alive that refers to other members.
struct Cut {
  Cut(const Mesh& mesh, const std::vector<Vec3d>& given, std::uint32_t uniform)
      : solid(made(make_solid(std::make_shared<Mesh>(mesh), {}, {}))),
        sites(given.empty() ? made(uniform_sites(solid, uniform, 5, {})) : given),
        t(made(tetrahedralize(sites, solid.box, {}))),
        diagram(t, solid.box),
        restricted(restrict_to_solid(SeenSolid(solid), diagram, {})),
        ownership(Ownership::from_groups(t.site_count(), {})),
        pieces(gather_pieces(restricted, ownership, {})) {}

  template <class T>
  static T made(Expected<T> expected) {
    if (!expected) throw std::runtime_error(expected.error().detail);
    return std::move(*expected);
  }

  Solid solid;
  std::vector<Vec3d> sites;
  Tetrahedralization t;
  VoronoiDiagram diagram;
  RestrictedDiagram restricted;
  Ownership ownership;
  Pieces pieces;
};

/// A prism whose outline crosses itself. The winding number is 1 in the large loop and -1 in the small one,
/// so pieces inside the small loop have negative volumes.
Mesh bow_tie(double small) { return prism_over({{-1, -1}, {small, small}, {small, -small}, {-1, 1}}); }

// A cube of 1 m and a grain of 8 µm that touches nothing. In the same group of parts, the grain is not counted. In a separate
// group, it is a part like any other.
TEST(UniteBySize, DustTakesNoFragmentFromItsGroupOfParts) {
  const double side = 8e-6;
  const Cut cut(joined({box({0, 0, 0}, {1, 1, 1}), box({1.5, 0, 0}, {1.5 + side, side, side})}), {}, 12);
  ASSERT_EQ(cut.solid.parts.size(), 2u);
  for (const bool same : {true, false}) {
    const PartContacts across{.pieces = {}, .group_of_part = {0, same ? 0u : 1u}};
    PieceGroups groups(cut.pieces.pieces.size());
    SizeLimits limits;
    limits.fragments = 6;
    unite_by_size(cut.restricted, cut.pieces, limits, &across, groups, {});
    std::array<int, 2> of_part{0, 0};
    for (std::uint32_t g = 0; g < groups.pieces(); ++g)
      if (groups.is_group(g)) ++of_part[cut.pieces.pieces[g].part];
    std::sort(of_part.begin(), of_part.end());  // whichever part is the cube
    EXPECT_EQ(of_part[0], 1);
    EXPECT_EQ(of_part[1], same ? 6 : 5);
  }
}

TEST(PieceGroups, PollsWhileAUnionMovesManyPieces) {
  int polls = 0;
  Execution execution;
  execution.watch = [&] { ++polls; };
  Pacer pacer(execution);
  constexpr std::uint32_t kHalf = 1u << 18;
  PieceGroups groups(2 * kHalf);
  for (const std::uint32_t first : {0u, kHalf})
    for (std::uint32_t p = 1; p < kHalf; ++p) groups.unite(first, first + p, pacer);
  polls = 0;
  groups.unite(0, kHalf, pacer);
  EXPECT_GE(polls, 100) << "one union of 262,144 pieces with as many others";
  polls = 0;
  EXPECT_EQ(groups.members(0, execution).size(), 2 * kHalf);
  EXPECT_GE(polls, 200);
}

TEST(PieceGroups, AreTheSetsThatWereUnitedNamedByTheirSmallestPiece) {
  Random random(3);
  constexpr std::uint32_t kPieces = 60;
  PieceGroups groups(kPieces);
  Pacer pacer(kUninterrupted);
  std::vector<std::uint32_t> expected(kPieces);  // the name of each piece's group
  for (std::uint32_t p = 0; p < kPieces; ++p) expected[p] = p;
  for (int step = 0; step < 80; ++step) {
    const auto a = static_cast<std::uint32_t>(random.uniform() * kPieces),
               b = static_cast<std::uint32_t>(random.uniform() * kPieces);
    const bool one = expected[a] == expected[b];
    const PieceGroups::Union united = groups.unite(a, b, pacer);
    EXPECT_EQ(united.kept == united.gone, one);
    const std::uint32_t low = std::min(expected[a], expected[b]), high = std::max(expected[a], expected[b]);
    std::replace(expected.begin(), expected.end(), high, low);
    EXPECT_EQ(groups.names(), expected);
    EXPECT_EQ(groups.name_of_set(united.kept), low);
    for (std::uint32_t p = 0; p < kPieces; ++p) {
      EXPECT_EQ(groups.is_group(p), expected[p] == p);
      if (expected[p] != p) continue;
      std::vector<std::uint32_t> members;
      for (std::uint32_t m = 0; m < kPieces; ++m)
        if (expected[m] == p) members.push_back(m);
      EXPECT_EQ(groups.members(p), members);
      EXPECT_EQ(groups.size(p), members.size());
      for (const std::uint32_t m : members) EXPECT_EQ(groups.set_of(m), groups.set_of(p));
    }
  }
}

TEST(GroupContacts, AreThoseOfAllCapsAfterAnyUnions) {
  const Cut cut(torus(24, 12), {}, 60);
  const auto n = static_cast<std::uint32_t>(cut.pieces.pieces.size());
  PieceGroups groups(n);
  GroupContacts contacts(cut.restricted, cut.pieces, groups, kAlone);
  Random random(7);
  for (int step = 0; step < 50; ++step) {
    std::map<std::uint32_t, std::vector<Neighbor>> expected;
    std::vector<PieceContact> all = find_piece_contacts(cut.restricted, cut.pieces, groups.names(), {});
    for (const PieceContact& c : all) {
      auto& of = expected[c.of];
      const auto same = [&](const Neighbor& x) { return x.group == c.with; };
      if (std::none_of(of.begin(), of.end(), same)) of.push_back({c.with, c.area});
    }
    // Some of these groups were never queried, some were, and some were united with others.
    for (std::uint32_t g = 0; g < n; g += 1 + static_cast<std::uint32_t>(step) % 3) {
      if (!groups.is_group(g)) continue;
      const std::vector<Neighbor> found = contacts.neighbors(g);
      ASSERT_EQ(found.size(), expected[g].size()) << g;
      for (std::size_t k = 0; k < found.size(); ++k) {
        EXPECT_EQ(found[k].group, expected[g][k].group);
        EXPECT_EQ(found[k].area, expected[g][k].area);  // equal to the bit, because the area decides unions
      }
    }
    const PieceContact& pick =
        all[static_cast<std::size_t>(random.uniform() * static_cast<double>(all.size()))];
    contacts.unite(pick.of, pick.with);
  }
}

TEST(VolumeSigns, AreThoseOfTheJoinedPiecesInTheFileWhereTheyAreKnown) {
  const Cut cut(bow_tie(0.6), {}, 200);
  const auto n = static_cast<std::uint32_t>(cut.pieces.pieces.size());
  const std::vector<PieceContact> all =
      find_piece_contacts(cut.restricted, cut.pieces, PieceGroups(n).names(), {});
  Random random(11);
  int negative = 0, positive = 0, unknown = 0;
  for (int run = 0; run < 60; ++run) {
    PieceGroups groups(n);
    Pacer pacer(kUninterrupted);
    VolumeSigns signs(cut.restricted, cut.pieces, kAlone);
    for (int step = 0; step < 12; ++step) {
      const PieceContact& pick =
          all[static_cast<std::size_t>(random.uniform() * static_cast<double>(all.size()))];
      const std::uint32_t a = groups.of(pick.of), b = groups.of(pick.with), name = std::min(a, b);
      if (a == b) continue;
      signs.unite(groups, a, b, name);
      groups.unite(a, b, pacer);
      const Piece joined = join_pieces(cut.restricted, cut.pieces, groups, name, {});
      const int in_file =
          file_volume(assemble(cut.restricted, cut.ownership, joined, Pivot::kCenterOfMass, {})).sign;
      const int known = signs.of(name);
      if (known != 0) {
        EXPECT_EQ(known, in_file);
      }
      ++(known < 0 ? negative : known > 0 ? positive : unknown);
    }
  }
  EXPECT_GT(negative, 10);
  EXPECT_GT(positive, 10);
  EXPECT_LT(unknown, 5);
}

/// The work in polls of a Pacer. Each poll counts for thousands of steps.
std::uint64_t polls_of_make_fragments(const Cut& cut, const SizeLimits& limits, FragmentSet& set) {
  const Polled made = polled([&](const Execution& execution) {
    set = make_fragments(cut.restricted, cut.ownership, Pivot::kCenterOfMass, limits, execution);
  });
  EXPECT_LT(made.longest_ms, kMostPollGapMs);
  return made.polls;
}

// All pieces inside the small loop become a single group of negative volume, which grows by one piece per
// round. Formerly its faces were joined and assembled in each round, and all caps were searched for
// neighbours.
TEST(Unite, AGroupThatGrowsForThousandsOfRoundsIsJoinedOnce) {
  std::vector<double> polls, pieces;
  for (const std::uint32_t sites : {2000u, 8000u}) {
    const Cut cut(bow_tie(0.6), {}, sites);
    FragmentSet set;
    polls.push_back(static_cast<double>(polls_of_make_fragments(cut, {}, set)));
    pieces.push_back(static_cast<double>(cut.pieces.pieces.size()));
    EXPECT_GT(set.certificate.united, sites / 10);
    EXPECT_EQ(set.certificate.open_edges, 0u);
    EXPECT_LT(set.certificate.relative_error, 1e-9);
  }
  EXPECT_LT(std::log(polls[1] / polls[0]), 1.15 * std::log(pieces[1] / pieces[0]));
}

// A cell that is surrounded by all others and has a higher name than they. Formerly a cell that united with
// it gave its own lower name to all contacts of the large cell.
TEST(Unite, AGroupWithManyNeighborsKeepsItsContactsWhenASmallOneJoins) {
  std::vector<double> polls, pieces;
  for (const int around : {1000, 4000}) {
    std::vector<Vec3d> sites;
    for (const Vec3f& p : sphere_with(2 * around, 0.9).positions) sites.push_back(to_double(p));
    sites.push_back({0, 0, 0});
    const Cut cut(cube(), sites, 0);
    FragmentSet set;
    SizeLimits limits;
    limits.max_fragments = 1;
    polls.push_back(static_cast<double>(polls_of_make_fragments(cut, limits, set)));
    pieces.push_back(static_cast<double>(cut.pieces.pieces.size()));
    EXPECT_EQ(set.fragments.size(), 1u);
  }
  EXPECT_LT(std::log(polls[1] / polls[0]), 1.2 * std::log(pieces[1] / pieces[0]));
}

TEST(Unite, CanBeInterruptedAnywhere) {
  const Cut cut(sphere_with(40'000), {}, 5'000);
  for (const SizeLimits& limits :
       {SizeLimits{}, SizeLimits{.max_fragments = 1}, SizeLimits{.max_triangles = 60'000}}) {
    FragmentSet set;
    EXPECT_GT(polls_of_make_fragments(cut, limits, set), 100u);
  }
}

TEST(Unite, CountsTheTrianglesThatItMakes) {
  const Cut cut(sphere_with(2000), {}, 50);
  Allowance allowance(0, 1ull << 40, [](std::uint64_t) { return Allowance::Answer::kGranted; });
  Execution execution;
  execution.allowance = &allowance;
  const FragmentSet set = make_fragments(cut.restricted, cut.ownership, Pivot::kCenterOfMass, {}, execution);
  std::uint64_t triangles = 0;
  for (const Fragment& f : set.fragments) triangles += f.indices.size() / 3;
  EXPECT_GE(allowance.bytes(), triangles * bytes_of(Product::kFragmentTriangles));
}

}  // namespace
}  // namespace fracture::test
