// A fragment with everything that a later hit needs to cut it again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/id.hpp"
#include "common/fragment/fragments.hpp"
#include "common/physics/collision_hulls.hpp"

namespace fracture {

struct KeptFragment {
  Fragment fragment;
  FragmentHulls hulls{};     ///< empty if none were requested
  double volume_file = 0;    ///< m³, as summed in the certificate
  Box box{};                 ///< in the frame of the source
  std::vector<Vec3f> far{};  ///< per vertex: its position in that frame; empty if the pivot is its origin
  /// Whether it lies in a convex region that no other fragment enters. If not, hulls of its pieces must stay in its own.
  bool is_in_convex = true;
  std::uint32_t instance =
      kNoIndex;  ///< index into the bodies of BrokenSolid::instances; kNoIndex: it is none

  const std::vector<Vec3f>& world() const { return far.empty() ? fragment.positions : far; }
};
using SharedFragment = std::shared_ptr<const KeptFragment>;

/// Takes a fragment that was made with Pivot::kSource, and moves its origin to `pivot`. Does not fill the hulls. The
/// result has the same bits as one that was made with that pivot. Throws Interrupted.
KeptFragment kept_with_pivot(Fragment made, Pivot pivot, const Execution& execution);

/// Bytes, including the object itself.
std::size_t memory_size(const KeptFragment& kept);
std::size_t memory_size(const Fragment& fragment);
std::size_t memory_size(const FragmentHulls& hulls);

}  // namespace fracture
