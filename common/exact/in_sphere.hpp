// Decides whether site e is inside the sphere through the positive tetrahedron (a, b, c, d), orient3d(a, b,
// c, d) > 0. Returns +1 if it is (e is in conflict with the tetrahedron), otherwise -1, and never 0.
//
// The tie rule, which is the same in every predicate on sites (Edelsbrunner & Shah 1996, regular
// triangulations of generic infinitesimal weights): each site s has an infinitesimal weight w_s > 0. The
// lexicographically smallest site (by x, then y, then z) has the largest weight, and each weight is
// infinitely larger than the next. Distances are |x - s|^2 - w_s, so the heavier site wins. The in-sphere
// polynomial is linear in the lifted coordinates |s|^2 - w_s. So an exact zero is decided by the first of the
// five sites, in lexicographic order, whose cofactor is not zero. For e, that cofactor is -orient3d(a, b, c,
// d) < 0, so e is inside. For a vertex v, it is orient3d of the tetrahedron with v replaced by e, and e is
// inside if that is negative. Coordinates are never perturbed. The five points must be distinct; |coordinate|
// <= 1e60.
#pragma once

#include "common/base/vec.hpp"
#include "common/exact/binary_scale.hpp"
#include "common/exact/predicate_counters.hpp"

namespace fracture::exact {

int in_sphere(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d, const Vec3d& e);

/// The same for points of a set. `scale` is the scale of a set that contains the five points, or a
/// default-constructed one.
int in_sphere(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d, const Vec3d& e,
              const BinaryScale& scale, PredicateCounters* counters = nullptr);

/// The same without the filter, for callers that have evaluated their own filter.
int in_sphere_exact(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d, const Vec3d& e,
                    const BinaryScale& scale, PredicateCounters* counters = nullptr);

}  // namespace fracture::exact
