#include "client/sound/modes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace fracture::sound {
namespace {

using std::numbers::pi;

struct Named {
  const char* name;
  SoundMaterial material;
};

// Ashby, "Materials Selection in Mechanical Design", 2011, appendix A: middle of the ranges; for wood, the
// geometric mean of the values across and along the grain. Ice: Petrovic, "Mechanical properties of ice and
// snow", 2003.
constexpr std::array<Named, 12> kMaterials = {{
    {"stone", {50e9, 2700, 0.25, 6e-3}},
    {"glass", {70e9, 2500, 0.22, 1.2e-3}},
    {"wood", {2.5e9, 500, 0.35, 2.5e-2}},
    {"concrete", {28e9, 2400, 0.2, 1.5e-2}},
    {"brick", {16e9, 1900, 0.2, 1.2e-2}},
    {"ceramic", {80e9, 2400, 0.24, 1.5e-3}},
    {"terracotta", {18e9, 1900, 0.22, 5e-3}},
    {"metal", {205e9, 7850, 0.29, 4e-4}},
    {"cast_iron", {110e9, 7200, 0.27, 2.5e-3}},
    {"ice", {9e9, 917, 0.33, 8e-3}},
    {"sandstone", {18e9, 2300, 0.25, 1e-2}},
    {"plaster", {5e9, 1200, 0.2, 2e-2}},
}};

constexpr double kLowest = 30, kHighest = 16000;  // Hz: the audible range
constexpr std::size_t kMostModes = 24;
constexpr int kMostWaves = 8;               // along a side
constexpr double kAir = 413, kSpeed = 343;  // impedance of air, Pa·s/m; speed of sound, m/s
constexpr double kLying = 12, kHeld = 40;   // 1/s: damping of all modes by the body's support

}  // namespace

const SoundMaterial& sound_material(const std::string& name) {
  const auto known = std::find_if(kMaterials.begin(), kMaterials.end(),
                                  [&](const Named& entry) { return name == entry.name; });
  return known != kMaterials.end() ? known->material : kMaterials.front().material;
}

double random_unit(std::uint64_t seed, std::uint64_t number) {
  std::uint64_t z = seed + 0x9e3779b97f4a7c15ull * (number + 1);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  z ^= z >> 31;
  return (static_cast<double>(z >> 11) + 0.5) / 9007199254740992.0;
}

glm::dvec3 sides_of(double mass, const glm::dvec3& moments, double density) {
  if (!(mass > 0)) return glm::dvec3(0);
  // Moments of a box: m (b² + c²) / 12 etc.
  const double sum = 0.5 * (moments.x + moments.y + moments.z);
  glm::dvec3 sides;
  for (int k = 0; k < 3; ++k) sides[k] = std::sqrt(std::max(0.0, 12 / mass * (sum - moments[k])));
  // Moments ascend, so sides descend. A hollow or ragged body has less mass than its box, so its walls are
  // thinner.
  const double filled = mass / density;
  sides.z = std::min(sides.z, filled / std::max(sides.x * sides.y, 1e-12));
  return glm::max(sides, glm::dvec3(1e-4));
}

std::vector<Mode> modes_of(const SoundMaterial& material, double mass, const glm::dvec3& sides, bool held,
                           std::uint64_t seed) {
  std::vector<Mode> modes;
  if (!(mass > 0)) return modes;
  const double length = sides.x, width = sides.y, thickness = sides.z;
  const double e = material.young, rho = material.density, nu = material.poisson;
  // Kirchhoff's plate of sides a, b (Leissa, "Vibration of Plates", 1969, eq. 4.20): f = π/2 √(D/ρh) (m²/a² + n²/b²).
  const double stiffness = 0.5 * pi * std::sqrt(e * thickness * thickness / (12 * rho * (1 - nu * nu)));
  const double shear = std::sqrt(e / (2 * (1 + nu)) / rho);  // m/s
  const double surface = 2 * length * width;
  const double radius = std::sqrt(surface / (4 * pi));
  const double at_x = random_unit(seed, 0), at_y = random_unit(seed, 1);
  for (int m = 1; m <= kMostWaves; ++m)
    for (int n = 1; n <= kMostWaves; ++n) {
      const double waves = m * m / (length * length) + n * n / (width * width);  // 1/m²
      const double bending = stiffness * waves;
      // Short waves of a thick plate are shear waves (Mindlin, 1951). The formula approaches the slower
      // of bending and shear waves, and blends the two in between.
      const double shearing = 0.5 * shear * std::sqrt(waves);
      const double frequency = 1 / (1 / bending + 1 / shearing);
      if (frequency < kLowest || frequency > kHighest) continue;
      const double shape = std::sin(m * pi * at_x) * std::sin(n * pi * at_y);
      // A mode's mass is a quarter of the plate's. Its mean square velocity over surface and time is an
      // eighth of A².
      const double velocity = 4 * shape / mass;
      // A surface that is small relative to the wavelength moves the air around itself and radiates little
      // sound.
      const double ka = 2 * pi * frequency / kSpeed * radius, efficiency = ka * ka / (1 + ka * ka);
      const double pressure =
          kAir * velocity * std::sqrt(0.125 * surface * efficiency / (2 * pi)) * std::sqrt(2);
      modes.push_back({frequency, pi * frequency * material.loss + (held ? kHeld : kLying), pressure});
    }
  std::sort(modes.begin(), modes.end(),
            [](const Mode& a, const Mode& b) { return a.frequency < b.frequency; });
  if (modes.size() > kMostModes) modes.resize(kMostModes);
  return modes;
}

double contact_time(double mass_a, const SoundMaterial& a, double mass_b, const SoundMaterial& b,
                    double radius, double approach) {
  const double inverse = (mass_a > 0 ? 1 / mass_a : 0) + (mass_b > 0 ? 1 / mass_b : 0);
  if (!(inverse > 0) || !(approach > 0) || !(radius > 0)) return 1e-3;
  const double mass = 1 / inverse;
  const double e = 1 / ((1 - a.poisson * a.poisson) / a.young + (1 - b.poisson * b.poisson) / b.young);
  return 2.87 * std::pow(mass * mass / (radius * e * e * approach), 0.2);
}

}  // namespace fracture::sound
