// Places in a request have the origin of the file. The engine works below the root node, whose place is the offset of
// the mesh (SourceFrame::offset).
#pragma once

#include "common/base/error.hpp"
#include "common/base/vec.hpp"
#include "common/pipeline/fracture.hpp"

namespace fracture {

/// No place may be farther than this from the root on any axis, m: doubles do not distinguish sites at a distance that is
/// many times the size of the mesh.
inline constexpr double kFarBelowRoot = 1e6;

/// Subtracts `offset` (m, y up) in double from every place: points and impacts of patterns (of `assigned`, too), hits, the
/// kept region and anchors. Corners of boxes that are farther than kFarBelowRoot are moved there. Error: kBadParameter, with
/// the parameter, for another place that is farther.
Expected<FractureParameters> below_root(FractureParameters parameters, const Vec3d& offset);

}  // namespace fracture
