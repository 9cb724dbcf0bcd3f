// Rows for the number of collision hulls.
#include <cstdint>

#include "common/parameters/fields.hpp"
#include "common/parameters/rows.hpp"

namespace fracture {

using parameter_fields::with_member;

std::vector<ParameterSpec> hull_parameter_rows() {
  std::vector<ParameterSpec> rows;
  rows.push_back(with_member(
      {.name = "max_hulls",
       .type = Type::kInteger,
       .min = 1,
       .max = kMostHulls,
       .doc =
           "Maximum number of convex hulls per fragment. Only ragged chunks, fragments that were merged, and fragments with openings "
           "have several hulls. A hull extends beyond its fragment only at the outer surface, so the hulls of neighbouring "
           "fragments do not overlap. A fragment with pieces of different parts, each with its own grain, has one hull per "
           "piece, even if that is more."},
      [](auto& r) -> auto& { return r.fracture.hull_limits.count; }));
  rows.push_back(with_member(
      {.name = "hull_excess",
       .type = Type::kNumber,
       .low = 1,
       .high = 1e6,
       .doc =
           "A fragment is divided among several hulls (at most `max_hulls`) if its hull would have more than this many times its "
           "volume. So things can fly through a window frame or a ring. Some fragments are never divided: curved shards, those "
           "with cut pieces of different parts, and those of more than 10,000 triangles. With a large value, no fragment is divided."},
      [](auto& r) -> auto& { return r.fracture.hull_limits.excess; }));
  for (ParameterSpec& spec : rows)
    spec.matters = [](const RequestParameters& r) {
      return r.physics != Physics::kNone || r.ue_collision != UeCollision::kNone;
    };
  return rows;
}

}  // namespace fracture
