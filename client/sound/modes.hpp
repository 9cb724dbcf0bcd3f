// How a body rings: its vibration modes, from its material and size.
//
// Modal synthesis. K. van den Doel and D. Pai, "The Sounds of Physical Shapes", Presence 7(4), 1998: a struck
// body is a bank of damped oscillators, each with a gain that depends on where and how it is struck. J.
// O'Brien, C. Shen and C. Gatchalian, "Synthesizing Sounds from Rigid-Body Simulations", SCA 2002: modes of
// each rigid body are excited by the contact impulses of the simulation. Their modes come from measurements
// and finite elements. Each hit creates hundreds of new fragments, so ours are those of the plate with the
// same mass and inertia, in closed form.
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
  /// Loss factor: 1 / Q. Decay grows with the frequency, so wooden things sound dull, whatever their shape
  /// (Wildes and Richards, "Recovering Material Properties from Sound", 1988).
  double loss;
};

/// The material with this name on the server, or stone if the name is unknown.
const SoundMaterial& sound_material(const std::string& name);

/// The sides in metres, descending, of the box with this mass and these principal moments (kg·m²). A sphere
/// gives the box with the same moments.
glm::dvec3 sides_of(double mass, const glm::dvec3& moments, double density);

struct Mode {
  double frequency;  ///< Hz
  double decay;      ///< 1/s: decay of the amplitude
  double pressure;   ///< Pa at one metre per N·s of an instantaneous impulse; signed
};

/// The audible modes, at most 24, ascending; none if the body is too small to be heard. `seed` decides where
/// it is struck. A supported body is damped more, most of all if it is fixed (`held`).
std::vector<Mode> modes_of(const SoundMaterial& material, double mass, const glm::dvec3& sides, bool held,
                           std::uint64_t seed);

/// Duration of the contact between two bodies in an impact, in seconds (Hertz, 1882; Johnson, "Contact
/// Mechanics", 1985, section 11.4): 2.87 (m² / (R E² v))^(1/5). Mass 0 means a fixed body. `radius`: of the
/// contact, in metres.
double contact_time(double mass_a, const SoundMaterial& a, double mass_b, const SoundMaterial& b,
                    double radius, double approach);

/// Uniform in 0 … 1 (exclusive), equal for equal arguments: one step of SplitMix64 (Steele, Lea, Flood,
/// 2014).
double random_unit(std::uint64_t seed, std::uint64_t number);

}  // namespace fracture::sound
