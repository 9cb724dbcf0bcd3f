// The bonds of a contact add up to its area, however its parts are cut.
#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <string>

#include "tests/structure/in_contact.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/same_bonds.hpp"

namespace fracture::test {
namespace {

/// Rotates by angles with rational sines and cosines (3-4-5 and 5-12-13), so that no face is parallel to an
/// axis.
Mesh askew(Mesh mesh) {
  for (Vec3f& p : mesh.positions) {
    const Vec3d q{p.x * 3 / 5.0 - p.y * 4 / 5.0, p.x * 4 / 5.0 + p.y * 3 / 5.0, p.z};
    p = {static_cast<float>(q.x), static_cast<float>(q.y * 5 / 13.0 - q.z * 12 / 13.0),
         static_cast<float>(q.y * 12 / 13.0 + q.z * 5 / 13.0)};
  }
  return mesh;
}

struct Assembly {
  std::string name;
  std::vector<Mesh> parts;
  /// The area in m² if the graph's area cannot be trusted: rounding separates flush faces that are rotated,
  /// and the graph counts some of them as inside.
  double area = 0;
};

std::vector<Assembly> assemblies() {
  const Mesh plank = box({-1.3, 0, -0.2}, {1.3, 0.1, 0.2}, 3),
             cross = box({-0.2, 0, -1.1}, {0.2, 0.1, 1.1}, 2);
  std::vector<Assembly> all{
      {"stacked", {plank, translated(plank, {0.3, 0.1f, 0.07})}},
      {"beside a gap", {plank, translated(plank, {0.3, 0.1009, 0.07})}},
      {"a cross with flush faces", {plank, cross}, 2 * 0.4 * 0.1},
      {"a cross, one deeper", {plank, translated(cross, {0, 0.03, 0})}},
      {"a leg", {plank, box({0.6, -1, -0.1}, {0.73, 0.07, 0.09}, 2)}},
      {"spheres", {ico_sphere(3), translated(ico_sphere(3), {1.3, 0.2, 0.1})}},
      {"one inside", {ico_sphere(3, 2), translated(ico_sphere(2), {0.3, 0.2, 0.1})}},
      {"a ring on a rod", {torus(24, 12), box({-0.45, -0.45, -2}, {0.8, 0.45, 2}, 2)}},
  };
  for (std::size_t k = 0, n = all.size(); k < n; ++k) {
    Assembly turned{all[k].name + ", askew", {}, all[k].area};
    for (const Mesh& part : all[k].parts) turned.parts.push_back(askew(part));
    all.push_back(std::move(turned));
  }
  return all;
}

TEST(ContactSums, AreTheAreaOfTheContact) {
  std::size_t input = 0;
  for (const Assembly& assembly : assemblies()) {
    ++input;
    std::size_t turn = 0;
    for (const bool rough : {false, true})
      for (const Pivot pivot : {Pivot::kCenterOfMass, Pivot::kSource}) {
        if (!has_turn(input, turn++, 2)) continue;
        SCOPED_TRACE(assembly.name + (rough ? ", rough" : ""));
        const Solid solid = solid_in_contact(assembly.parts);
        FractureParameters p;
        p.parts = Parts::kApart;
        p.sites = 60;
        p.pivot = pivot;
        if (rough) p.roughness = {.amplitude = 0.01, .frequency = 3};
        const Fractured made = fracture_solid(solid, p);
        std::map<std::pair<std::uint32_t, std::uint32_t>, double> sums;
        for (const Bond& bond : bonds_across(made.set))
          sums[std::minmax({made.set.fragments[bond.a].part, made.set.fragments[bond.b].part})] += bond.area;
        ASSERT_EQ(solid.contacts->contacts.size(), 1u);
        const Contact& contact = solid.contacts->contacts[0];
        const double area = assembly.area > 0 ? assembly.area : contact.area;
        ASSERT_GT(area, 0);
        EXPECT_NEAR((sums[{contact.a, contact.b}]) / area, 1, 1e-5);
      }
  }
}

TEST(ContactSums, HaveTheSameBitsOnAnyNumberOfThreads) {
  FractureParameters p;
  p.parts = Parts::kApart;
  p.sites = 200;
  std::vector<Mesh> parts;
  for (int k = 0; k < 20; ++k) parts.push_back(box({k * 0.1, 0, 0}, {k * 0.1 + 0.1, 1, 1}, 2));
  const Solid solid = solid_in_contact(parts);
  const std::vector<Bond> one = fracture_solid(solid, p).set.bonds;
  for (const int threads : {2, 3}) {
    const std::vector<Bond> more = fracture_solid(solid, p, threads).set.bonds;
    ASSERT_EQ(more.size(), one.size());
    EXPECT_TRUE(same_bits(more, one));
  }
}

}  // namespace
}  // namespace fracture::test
