// What stands and what falls. Fragments hang together by bonds; the anchored ones are held from outside. A
// fragment falls when no chain of unbroken bonds leads from it to an anchored one.
//
// How much each bond carries: the fragments are rigid, each bond is a short elastic beam at its cap's
// centroid (Euler & Bernoulli; section = a disc of the bond's area, length = the distance of the centres of
// mass), the anchored fragments do not move, and gravity pulls at the centres of mass. The balance of forces
// and moments is solved by conjugate gradients (Hestenes & Stiefel 1952) with the 6 x 6 diagonal blocks as
// preconditioner, in loops of our own: the figures are part of answers whose bits every compiler must give,
// and the kernels of linear algebra libraries do not. Where the structure leaves one way for a load (a tower,
// a cantilever, any tree of bonds) forces and moments are those of statics, whatever the stiffness; elsewhere
// they are shared by stiffness: an estimate.
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
  double tension = 0;  ///< N along the bond's normal; negative: pressed together
  double shear = 0;    ///< N across it
  double bending = 0;  ///< N·m, about axes in the cap
  double torsion = 0;  ///< N·m, about the normal
  double stress = 0;   ///< Pa: largest tensile stress in the section (Rankine); 0 when all is pressed
};

/// A companion of a FragmentSet.
struct Support {
  SupportOptions asked;
  std::vector<std::uint32_t> falling;  ///< indices of fragments, ascending; without those that are gone
  std::vector<BondLoad> loads;         ///< per bond
  std::vector<std::uint32_t>
      weak;                    ///< indices of overloaded bonds, the largest stress relative to strength first
  std::uint32_t anchored = 0;  ///< how many fragments are held
  std::uint32_t unknown = 0;   ///< ids in `broken` that no fragment has
  double residual = 0;         ///< of the balance, relative to the weight; 1e-9 when solved
};

/// Linear in the bonds times the iterations, which are bounded. Throws Interrupted.
Support analyze_support(const FragmentSet& set, const AnchoredFragments& anchored,
                        const SupportOptions& options, const Execution& execution);

}  // namespace fracture
