// Mass properties in the frame of a fragment's node. The node of an instance is rotated and scaled; those of other fragments are
// not.
#pragma once

#include "common/gltf/json_text.hpp"
#include "common/physics/principal_axes.hpp"
#include "common/pipeline/fractured_solid.hpp"

namespace fracture {

/// Writes the centre of mass as seen from the node. `instance`: null, or how the node places its shape.
inline void write_center_of_mass(JsonText& json, const Fragment& f, const InstancedBodies::Body* instance) {
  if (instance == nullptr)
    json.value(f.mass.center_of_mass - f.pivot);
  else
    json.rounded(instance->place().unmoved(f.mass.center_of_mass));
}

/// The rotation from principal axes to the node's frame.
inline Quaternion principal_rotation(const PrincipalAxes& axes, const InstancedBodies::Body* instance) {
  return instance == nullptr ? axes.rotation : product(inverse(instance->place().rotation), axes.rotation);
}

}  // namespace fracture
