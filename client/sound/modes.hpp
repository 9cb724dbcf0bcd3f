// How a body rings: its vibration modes, from what it is made of and how large it is.
//
// Modal synthesis: K. van den Doel and D. Pai, "The Sounds of Physical Shapes", Presence 7(4), 1998 (a struck body is a
// bank of damped oscillators, each with a gain that depends on where and how it is struck); J. O'Brien, C. Shen and
// C. Gatchalian, "Synthesizing Sounds from Rigid-Body Simulations", SCA 2002 (modes of each rigid body, excited by the
// contact impulses of the simulation). Theirs come from measurements and from finite elements; fragments are new in
// every hit and by the hundred, so ours are those of the plate with the same mass and inertia, in closed form.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace fracture::sound {

struct SoundMaterial {
  double young;    ///< Pa
  double density;  ///< kg/m³
  double poisson;
  /// Loss factor: 1 / Q. Decay grows with the frequency: what is wooden is dull, whatever its shape (Wildes and Richards,
  /// "Recovering Material Properties from Sound", 1988).
  double loss;
};

/// By the server's name of a material; stone where it is not known.
const SoundMaterial& sound_material(const std::string& name);

/// The sides of the box with this mass and these principal moments (kg·m²), descending, metres. A sphere's moments give
/// its box.
glm::dvec3 sides_of(double mass, const glm::dvec3& moments, double density);

struct Mode {
  double frequency;  ///< Hz
  double decay;      ///< 1/s, of the amplitude
  double pressure;   ///< Pa at one metre for each N·s of an impulse that is over at once; with a sign
};

/// The audible ones, at most 24, ascending; none where the body is too small to be heard. `seed` is where it is struck.
/// A supported body loses more (`held`: it stands fast in something).
std::vector<Mode> modes_of(const SoundMaterial& material, double mass, const glm::dvec3& sides, bool held,
                           std::uint64_t seed);

/// Seconds that two bodies touch in an impact (Hertz, 1882; Johnson, "Contact Mechanics", 1985, section 11.4): 2.87
/// (m² / (R E² v))^(1/5). A mass of 0 is a fixed body. `radius`: of the contact, metres.
double contact_time(double mass_a, const SoundMaterial& a, double mass_b, const SoundMaterial& b,
                    double radius, double approach);

/// Uniform in 0 … 1 (exclusive), equal for equal arguments: one step of SplitMix64 (Steele, Lea, Flood, 2014).
double random_unit(std::uint64_t seed, std::uint64_t number);

}  // namespace fracture::sound
