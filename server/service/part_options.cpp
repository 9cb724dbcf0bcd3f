#include "server/service/part_options.hpp"

#include <algorithm>

#include "common/gltf/part_materials.hpp"
#include "common/solid/part_selection.hpp"

namespace fracture {
namespace {

InteriorLook named(InteriorLook look, const RequestParameters& parameters) {
  if (!look.name && look.material.empty() && !parameters.material.empty())
    look.name = "Interior_" + parameters.material;
  return look;
}

}  // namespace

PartOptions::PartOptions(const RequestParameters& request, const Solid& solid, const Execution& execution)
    : request_(request), all_{&request} {
  if (request.assign.empty()) return;
  std::vector<PartSelector> selectors;
  for (const Assignment& entry : request.assign) {
    selectors.push_back(entry.selector);
    all_.push_back(entry.parameters.get());
  }
  for (const std::uint32_t entry : choose_parts(solid, selectors, execution).of_part)
    of_part_.push_back(entry == kNoIndex ? 0 : entry + 1);
}

Expected<InteriorMaterials> PartOptions::interior(const InteriorLook& look, const Solid& solid,
                                                  std::uint32_t pieces, const Execution& execution) const {
  if (of_part_.empty()) return interior_materials(look, solid, execution, pieces);
  std::vector<InteriorLook> looks;
  for (const RequestParameters* const parameters : all_) {
    InteriorLook own = parameters == &request_ ? look : parameters->interior;
    own.uvs = look.uvs;
    own.detail = look.detail;
    own.has_maps = look.has_maps;
    looks.push_back(named(std::move(own), *parameters));
  }
  return interior_materials_of_parts(looks, of_part_, solid, execution, pieces);
}

ExteriorMaterials PartOptions::exterior(const Solid& solid, const Execution& execution) const {
  if (of_part_.empty()) return exterior_materials(request_.exterior, *solid.source, execution);
  std::vector<ExteriorLook> looks;
  for (const RequestParameters* const parameters : all_) looks.push_back(parameters->exterior);
  return exterior_materials_of_parts(looks, of_part_, solid, execution);
}

void PartOptions::add_surfaces(GltfOptions& options) const {
  const std::vector<ContactSurface>& further = options.surfaces;
  std::vector<std::uint32_t> number;  // per member of all_
  for (const RequestParameters* const parameters : all_) {
    const ContactSurface surface{parameters->physical.friction, parameters->physical.restitution};
    const auto at = std::find(further.begin(), further.end(), surface);
    if (surface == ContactSurface{options.friction, options.restitution}) {
      number.push_back(0);
    } else {
      number.push_back(static_cast<std::uint32_t>(at - further.begin()) + 1);
      if (at == further.end()) options.surfaces.push_back(surface);
    }
  }
  for (const std::uint32_t k : of_part_) options.surface_of_part.push_back(number[k]);
}

}  // namespace fracture
