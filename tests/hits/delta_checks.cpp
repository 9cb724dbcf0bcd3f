#include "tests/hits/delta_checks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <span>

#include "common/contacts/contacts.hpp"
#include "common/hits/difference.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/same_bonds.hpp"

namespace fracture::test {
namespace {

/// Equal to the last bit, including the sign of a zero.
template <class T>
bool same_bits(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}
template <class T>
bool same_bits(const std::vector<std::vector<T>>& a, const std::vector<std::vector<T>>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const auto& x, const auto& y) { return same_bits(x, y); });
}

void expect_same(const Fragment& a, const Fragment& b) {
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.sites, b.sites);
  EXPECT_EQ(a.part, b.part);
  EXPECT_EQ(a.part_cells, b.part_cells);
  EXPECT_EQ(a.density_share, b.density_share);
  EXPECT_EQ(a.node, b.node);
  EXPECT_TRUE(same_bits(a.pivot, b.pivot));
  EXPECT_TRUE(same_bits(a.positions, b.positions));
  EXPECT_TRUE(same_bits(a.attributes.normals, b.attributes.normals));
  EXPECT_TRUE(same_bits(a.attributes.tangents, b.attributes.tangents));
  EXPECT_TRUE(same_bits(a.attributes.uvs, b.attributes.uvs));
  EXPECT_TRUE(same_bits(a.attributes.colors, b.attributes.colors));
  EXPECT_TRUE(same_bits(a.bodies, b.bodies));
  EXPECT_TRUE(same_bits(a.caps, b.caps));
  EXPECT_TRUE(same_bits(a.surface_area, b.surface_area));
  EXPECT_EQ(a.cap_sum, b.cap_sum);
  EXPECT_EQ(a.open_edges, b.open_edges);
  EXPECT_EQ(a.indices, b.indices);
  EXPECT_EQ(a.topology, b.topology);
  ASSERT_EQ(a.primitives.size(), b.primitives.size());
  for (std::size_t k = 0; k < a.primitives.size(); ++k)
    EXPECT_TRUE(same_bits(a.primitives[k], b.primitives[k]));
  EXPECT_TRUE(same_bits(a.mass, b.mass));
  EXPECT_TRUE(same_bits(a.exterior_area, b.exterior_area));
  EXPECT_TRUE(same_sheet(a.sheet.get(), b.sheet.get()));
}

void expect_same(std::span<const CollisionHull> a, std::span<const CollisionHull> b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a[k].points, b[k].points);
    EXPECT_EQ(a[k].triangles, b[k].triangles);
  }
}

void expect_same(const FragmentSet& a, const FragmentSet& b) {
  ASSERT_EQ(a.fragments.size(), b.fragments.size());
  for (std::size_t k = 0; k < a.fragments.size(); ++k) {
    SCOPED_TRACE("fragment " + std::to_string(k));
    expect_same(a.fragments[k], b.fragments[k]);
  }
  ASSERT_EQ(a.bonds.size(), b.bonds.size());
  for (std::size_t k = 0; k < a.bonds.size(); ++k) EXPECT_TRUE(test::same_bits(a.bonds[k], b.bonds[k])) << k;
  EXPECT_TRUE(same_bits(a.lattice_step, b.lattice_step));
  EXPECT_TRUE(same_bits(a.lattice_ratio, b.lattice_ratio));
  EXPECT_EQ(a.certificate.open_edges, b.certificate.open_edges);
  EXPECT_TRUE(same_bits(a.certificate.volume_in, b.certificate.volume_in));
  EXPECT_TRUE(same_bits(a.certificate.volume_out, b.certificate.volume_out));
  EXPECT_TRUE(same_bits(a.certificate.volume_file, b.certificate.volume_file));
  EXPECT_TRUE(same_bits(a.certificate.relative_error, b.certificate.relative_error));
  EXPECT_TRUE(same_bits(a.certificate.area_in, b.certificate.area_in));
  EXPECT_TRUE(same_bits(a.certificate.area_out, b.certificate.area_out));
  EXPECT_TRUE(same_bits(a.certificate.pocket_volume, b.certificate.pocket_volume));
  EXPECT_TRUE(same_bits(a.certificate.pocket_area, b.certificate.pocket_area));
  EXPECT_EQ(a.certificate.unmirrored_caps, b.certificate.unmirrored_caps);
  EXPECT_EQ(a.certificate.sites_asked, b.certificate.sites_asked);
  EXPECT_EQ(a.certificate.cells, b.certificate.cells);
  EXPECT_EQ(a.certificate.islands, b.certificate.islands);
  EXPECT_EQ(a.certificate.united, b.certificate.united);
  EXPECT_EQ(a.certificate.dropped, b.certificate.dropped);
  EXPECT_EQ(a.certificate.fragments, b.certificate.fragments);
  EXPECT_EQ(a.certificate.crossing_caps, b.certificate.crossing_caps);
  EXPECT_TRUE(same_bits(a.certificate.sheet_area_in, b.certificate.sheet_area_in));
  EXPECT_TRUE(same_bits(a.certificate.sheet_area_out, b.certificate.sheet_area_out));
}

/// Compares the members that hits change one by one, so that a failure says which one differs.
void expect_same(const Report& a, const Report& b) {
  EXPECT_EQ(a.sites.given, b.sites.given);
  EXPECT_EQ(a.sites.used, b.sites.used);
  EXPECT_TRUE(a.size == b.size);
  EXPECT_TRUE(a.kept == b.kept);
  ASSERT_EQ(a.hulls.has_value(), b.hulls.has_value());
  if (a.hulls) {
    EXPECT_EQ(a.hulls->hulls, b.hulls->hulls);
    EXPECT_EQ(a.hulls->excess, b.hulls->excess);
  }
  EXPECT_TRUE(a.rough_cuts == b.rough_cuts);
  EXPECT_EQ(a.remarks.notes, b.remarks.notes);
  EXPECT_EQ(a.remarks.warnings, b.remarks.warnings);
  EXPECT_EQ(a, b);
}

void expect_same_companions(const FracturedSolid& a, std::uint32_t i, const FracturedSolid& b,
                            std::uint32_t j) {
  expect_same(a.hulls.of(i), b.hulls.of(j));
  EXPECT_EQ(a.anchored.contains(i), b.anchored.contains(j));
}

/// Maps ids of fragments to their indices.
using ById = std::map<std::uint64_t, std::uint32_t>;
ById by_id(const FragmentSet& set) {
  ById result;
  for (std::uint32_t k = 0; k < set.fragments.size(); ++k) result[set.fragments[k].id] = k;
  return result;
}

}  // namespace

void expect_same(const FracturedSolid& a, const FracturedSolid& b) {
  expect_same(a.set, b.set);
  for (std::uint32_t k = 0; k < a.set.fragments.size(); ++k) {
    SCOPED_TRACE("companions of fragment " + std::to_string(k));
    expect_same_companions(a, k, b, k);
  }
  EXPECT_EQ(a.anchored.count, b.anchored.count);
  ASSERT_EQ(a.rest.has_value(), b.rest.has_value());
  if (a.rest) {
    EXPECT_EQ(a.rest->figures, b.rest->figures);
    EXPECT_EQ(a.rest->filtered, b.rest->filtered);
    EXPECT_EQ(a.rest->filters.filters, b.rest->filters.filters);
    EXPECT_EQ(a.rest->filters.of_body, b.rest->filters.of_body);
  }
  for (std::size_t k = 0; k < a.set.fragments.size(); ++k) {
    const InstancedBodies::Body *x = a.instances.of(k), *y = b.instances.of(k);
    ASSERT_EQ(x == nullptr, y == nullptr) << k;
    if (x == nullptr) continue;
    EXPECT_TRUE(x->rotation == y->rotation && x->scale == y->scale && x->translation == y->translation);
    EXPECT_EQ(a.instances.numbers[x->shape], b.instances.numbers[y->shape]) << k;
  }
  expect_same(a.report, b.report);
  EXPECT_EQ(a.point_of_site, b.point_of_site);
  EXPECT_EQ(a.hierarchy.cluster_of_fragment, b.hierarchy.cluster_of_fragment);
  ASSERT_EQ(a.hierarchy.levels.size(), b.hierarchy.levels.size());
}

void expect_difference(const FracturedSolid& before, const FracturedSolid& after, const Delta& delta) {
  const ById was = by_id(before.set), is = by_id(after.set);
  std::vector<std::uint64_t> added, gone;
  for (const Fragment& f : after.set.fragments)
    if (!was.contains(f.id)) added.push_back(f.id);
  for (const Fragment& f : before.set.fragments)
    if (!is.contains(f.id)) gone.push_back(f.id);
  EXPECT_EQ(delta.added, added);
  EXPECT_EQ(delta.gone, gone);
  for (const std::uint64_t id : delta.changed) EXPECT_TRUE(was.contains(id) && is.contains(id)) << id;
  for (const auto& [id, k] : is) {
    if (!was.contains(id) || std::count(delta.changed.begin(), delta.changed.end(), id) > 0) continue;
    SCOPED_TRACE("untouched " + std::to_string(id));
    expect_same(before.set.fragments[was.at(id)], after.set.fragments[k]);
    expect_same_companions(before, was.at(id), after, k);
  }
}

namespace {

/// The selection contains only the fragments that the delta names, and their bonds.
void expect_selection(const FracturedSolid& from, FracturedSolid selected) {
  keep_changed(selected);
  const FragmentSet &whole = from.set, &part = selected.set;
  const Delta& delta = selected.delta.value();
  EXPECT_EQ(part.fragments.size(), delta.added.size() + delta.changed.size());
  const ById all = by_id(whole);
  for (std::uint32_t k = 0; k < part.fragments.size(); ++k) {
    const std::uint32_t there = all.at(part.fragments[k].id);
    expect_same(part.fragments[k], whole.fragments[there]);
    expect_same_companions(selected, k, from, there);
  }
  const auto id_of = [&](std::uint32_t k) {
    return k < part.fragments.size() ? part.fragments[k].id : delta.neighbors.at(k - part.fragments.size());
  };
  std::map<std::pair<std::uint64_t, std::uint64_t>, const Bond*> bonds;  // by ids
  for (const Bond& b : part.bonds) {
    EXPECT_LT(b.a, part.fragments.size());
    EXPECT_LT(b.a, b.b);
    bonds[std::minmax(id_of(b.a), id_of(b.b))] = &b;
  }
  const ById kept = by_id(part);
  std::size_t expected = 0;
  for (const Bond& b : whole.bonds) {
    const std::uint64_t x = whole.fragments[b.a].id, y = whole.fragments[b.b].id;
    if (!kept.contains(x) && !kept.contains(y)) continue;
    ++expected;
    const auto at = bonds.find(std::minmax(x, y));
    ASSERT_NE(at, bonds.end());
    EXPECT_EQ(at->second->area, b.area);
    EXPECT_EQ(at->second->normal, id_of(at->second->a) == x ? b.normal : -1.0 * b.normal);
  }
  EXPECT_EQ(part.bonds.size(), expected);
  if (!from.rest) return;
  std::vector<std::array<std::uint64_t, 2>> filtered;
  for (const auto& pair : from.rest->filtered)
    if (kept.contains(pair[0]) || kept.contains(pair[1])) filtered.push_back(pair);
  EXPECT_EQ(selected.rest.value().filtered, filtered);
}

}  // namespace

int expect_hits(const Mesh& mesh, const FractureParameters& all, int threads) {
  Execution execution;
  execution.threads = threads;
  StageTimings timings;
  Expected<Solid> solid = make_solid(std::make_shared<Mesh>(mesh), {}, execution);
  if (!solid) throw std::runtime_error(solid.error().detail);
  keep_contacts(*solid, {}, execution);
  keep_instances(*solid, execution);
  FractureParameters p = all;
  p.hits.clear();
  Expected<KeptAnswer> last = fracture_and_keep(*solid, p, execution, timings);
  if (!last) throw std::runtime_error(last.error().detail);
  FracturedSolid before = last->fractured;
  if (!short_tests()) expect_same(before, fracture_solid(*solid, p));
  int local = 0;
  for (std::size_t k = 0; k < all.hits.size(); ++k) {
    SCOPED_TRACE("hit " + std::to_string(k + 1));
    p.hits.push_back(all.hits[k]);
    Expected<KeptAnswer> next = fracture_delta(*solid, last->base, p, {1}, execution, timings);
    if (!next) throw std::runtime_error(next.error().detail);
    local += next->local;
    if (short_tests() && k + 1 < all.hits.size()) {
      before = next->fractured;
      last = std::move(next);
      continue;
    }
    const FracturedSolid after = fracture_solid(*solid, p);
    const FracturedSolid& answer = next->fractured;
    expect_same(answer, after);
    EXPECT_TRUE(answer.delta.has_value());
    if (!answer.delta || testing::Test::HasFailure()) return local;
    expect_difference(before, after, *answer.delta);
    expect_selection(after, answer);
    if (p.levels.empty()) {
      const Expected<KeptAnswer> part =
          fracture_delta(*solid, last->base, p, {1, /*only_changed=*/true}, execution, timings);
      if (!part) throw std::runtime_error(part.error().detail);
      FracturedSolid expected = answer;
      keep_changed(expected);
      expect_same(part->fractured, expected);
    }
    before = after;
    last = std::move(next);
  }
  return local;
}

FractureParameters hits_on(const Mesh& mesh, std::uint32_t sites, double radius, std::uint64_t seed) {
  FractureParameters p;
  p.sites = sites;
  p.seed = seed;
  p.hulls = Hulls::kConvex;
  p.rest = LocalRest::kFractured;
  const Box box = box_of(mesh);
  const Vec3d x{0.45 * box.size().x, 0, 0}, y{0, 0.3 * box.size().y, 0};
  for (const Vec3d& at : {x + y, -1.0 * x, -1.0 * x})
    p.hits.push_back({box.center() + at, radius * box.longest_side(), 12});
  return p;
}

}  // namespace fracture::test
