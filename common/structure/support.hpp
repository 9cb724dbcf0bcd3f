// Analyzes which fragments stand and which fall. Fragments hold together by bonds, and anchored fragments
// are held from outside. A fragment falls if no chain of unbroken bonds connects it to an anchored one.
//
// The load on each bond is computed from a model of rigid fragments. Each bond is a short elastic beam at
// its cap's centroid (Euler & Bernoulli; section: a disc of the bond's area; length: the distance of the
// centres of mass). The anchored fragments do not move, and gravity pulls at the centres of mass. Conjugate
// gradients (Hestenes & Stiefel 1952) solve the balance of forces and moments, with the 6 x 6 diagonal
// blocks as preconditioner. The loops are our own, because the results must have the same bits with every
// compiler, which linear algebra libraries do not ensure. If a load has only one path (a tower, a
// cantilever, any tree of bonds), forces and moments are those of statics, whatever the stiffness.
// Otherwise they are shared by stiffness, which is an estimate.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"
#include "common/structure/anchors.hpp"

namespace fracture {

struct SupportOptions {
  Vec3d gravity{0, -9.81, 0};         ///< m/s²
  double density = 1000;              ///< kg/m³
  double strength = 1e6;              ///< Pa; a bond breaks at this tensile stress times Bond::strength
  std::vector<std::uint64_t> broken;  ///< ids of fragments that are gone, with their bonds
};

/// The load on a bond. Zero if its fragments fall, are gone, or are both anchored.
struct BondLoad {
  double tension = 0;  ///< N along the bond's normal; negative: compression
  double shear = 0;    ///< N across the normal
  double bending = 0;  ///< N·m, about axes in the cap
  double torsion = 0;  ///< N·m, about the normal
  double stress = 0;   ///< Pa: largest tensile stress in the section (Rankine); 0 if all of it is compressed
};

/// A companion of a FragmentSet.
struct Support {
  SupportOptions asked;
  std::vector<std::uint32_t> falling;  ///< indices of fragments, ascending; without those in `broken`
  std::vector<BondLoad> loads;         ///< per bond
  /// Indices of overloaded bonds, the largest stress relative to strength first
  std::vector<std::uint32_t> weak;
  std::uint32_t anchored = 0;  ///< number of held fragments
  std::uint32_t unknown = 0;   ///< number of ids in `broken` that no fragment has
  double residual = 0;         ///< residual of the balance, relative to the weight; 1e-9 if solved
};

/// Runs the analysis. Linear in the bonds times the iterations, which are bounded. Throws Interrupted.
Support analyze_support(const FragmentSet& set, const AnchoredFragments& anchored,
                        const SupportOptions& options, const Execution& execution);

}  // namespace fracture
