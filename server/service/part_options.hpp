// The output options of a request whose parts are made of different materials (`assign`).
#pragma once

#include <cstdint>
#include <vector>

#include "common/gltf/gltf_writer.hpp"
#include "common/parameters/parameters.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// The parameters of each part of a solid.
class PartOptions {
 public:
  /// Borrows the request. Throws Interrupted.
  PartOptions(const RequestParameters& request, const Solid& solid, const Execution& execution);

  /// The materials of cuts and of the outside. Without `assign`, they are those of a request for one material. Cuts of a named
  /// material are called Interior_<material> if the request has several and gives no name. `look`: of the request. Errors: those of
  /// interior_materials(). Throw Interrupted.
  Expected<InteriorMaterials> interior(const InteriorLook& look, const Solid& solid, std::uint32_t pieces,
                                       const Execution& execution) const;
  ExteriorMaterials exterior(const Solid& solid, const Execution& execution) const;
  /// Adds the surfaces of parts that are made of other materials.
  void add_surfaces(GltfOptions& options) const;

 private:
  const RequestParameters& request_;
  std::vector<const RequestParameters*> all_;  ///< of the request, then of each entry
  std::vector<std::uint32_t> of_part_;         ///< per part: index into all_; empty: no part has an entry
};

}  // namespace fracture
