#include "common/pipeline/below_root.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <variant>

#include "common/base/words.hpp"
#include "common/mesh/frame.hpp"

namespace fracture {
namespace {

class Shift {
 public:
  explicit Shift(const Vec3d& offset) : offset_(offset) {}

  void move(Vec3d& place, const char* parameter) {
    place = place - offset_;
    for (int axis = 0; axis < 3; ++axis)
      if (!(std::fabs(place[axis]) <= kFarBelowRoot) && !too_far_) too_far_ = parameter;
  }
  void move(std::vector<Vec3d>& places, const char* parameter) {
    for (Vec3d& place : places) move(place, parameter);
  }
  void move(Box& box) const {
    for (Vec3d* corner : {&box.min, &box.max}) {
      *corner = *corner - offset_;
      for (int axis = 0; axis < 3; ++axis)
        (*corner)[axis] = std::clamp((*corner)[axis], -kFarBelowRoot, kFarBelowRoot);
    }
  }
  void move(SitePattern& pattern) {
    std::visit(
        [&](auto& p) {
          if constexpr (requires { p.points; }) move(p.points, "points");
          if constexpr (requires { p.impacts; }) move(p.impacts, "impacts");
        },
        pattern);
  }
  void move(Region& region) {
    if (region.shape == Region::Shape::kBox)
      move(region.box);
    else
      move(region.center, "keep_center");
  }
  void move(Anchors& anchors) {
    for (HalfSpace& plane : anchors.planes) {  // the normals are not zero
      plane.point = plane.point - offset_;
      plane.offset -= dot(offset_, plane.normal) / length(plane.normal);
    }
    for (Box& box : anchors.boxes) move(box);
    move(anchors.points, "anchor_points");
  }

  /// The first parameter with a place that is too far away; null: none.
  const char* too_far() const { return too_far_; }

 private:
  Vec3d offset_;
  const char* too_far_ = nullptr;
};

}  // namespace

Expected<FractureParameters> below_root(FractureParameters parameters, const Vec3d& offset) {
  Shift shift(offset);
  shift.move(parameters.pattern);
  for (AssignedParts& entry : parameters.assigned) {
    auto breaks = std::make_shared<FractureParameters>(*entry.breaks);
    shift.move(breaks->pattern);
    entry.breaks = std::move(breaks);
  }
  for (LocalImpact& hit : parameters.hits) shift.move(hit.point, "local_point");
  if (parameters.keep) shift.move(*parameters.keep);
  shift.move(parameters.anchors);
  if (shift.too_far())
    return fail(ErrorCode::kBadParameter,
                std::string("A place in '") + shift.too_far() + "' is more than " +
                    short_number(kFarBelowRoot) + " m from the mesh's root node, which is at " +
                    to_text(offset) + ". Give places in metres, with y up, measured from the file's origin.",
                shift.too_far());
  return parameters;
}

}  // namespace fracture
