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
           "Maximum number of convex hulls per fragment. Only ragged chunks, merged fragments and fragments with openings "
           "have more than one hull. Hulls of neighbours do not overlap. A fragment made of parts with different grains "
           "has one hull per piece, even if this exceeds the maximum."},
      [](auto& r) -> auto& { return r.fracture.hull_limits.count; }));
  rows.push_back(with_member(
      {.name = "hull_excess",
       .type = Type::kNumber,
       .low = 1,
       .high = 1e6,
       .doc =
           "A fragment (such as a window frame) is divided among several hulls if a single hull would have more than this "
           "many times the fragment's volume. Curved shards, fragments with cut pieces of different parts, and fragments "
           "of more than 10,000 triangles are never divided."},
      [](auto& r) -> auto& { return r.fracture.hull_limits.excess; }));
  for (ParameterSpec& spec : rows)
    spec.matters = [](const RequestParameters& r) {
      return r.physics != Physics::kNone || r.ue_collision != UeCollision::kNone;
    };
  return rows;
}

}  // namespace fracture
