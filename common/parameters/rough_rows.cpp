// Rows for rough cuts: how far cuts deviate from planes (common/rough).
#include "common/materials/materials.hpp"
#include "common/parameters/fields.hpp"
#include "common/parameters/rows.hpp"

namespace fracture {

using parameter_fields::with_member;

// Lengths are relative to the solid's size, so presets suit meshes of any scale, including files whose unit is a guess.
std::vector<ParameterSpec> rough_parameter_rows() {
  std::vector<ParameterSpec> rows;
  rows.push_back(with_member(
      {.name = "rough_amplitude",
       .type = Type::kNumber,
       .low = 0,
       .high = 0.25,
       .doc =
           "How far noise moves cut faces out of their planes, as a fraction of the solid's size. This size is the cube "
           "root of the volume of the largest part. The server lowers an amplitude that is too high for "
           "`rough_frequency`. 0: flat cuts."},
      [](auto& r) -> auto& { return r.fracture.roughness.amplitude; }));
  rows.back().matters = [](const RequestParameters& r) {
    const MaterialPreset* preset = find_material_preset(r.material);  // its roughness is overridden by 0
    return r.fracture.roughness.amplitude > 0 || (preset && preset->roughness.amplitude > 0);
  };
  const std::size_t first = rows.size();
  rows.push_back(with_member(
      {.name = "rough_frequency",
       .type = Type::kNumber,
       .low = 0.1,
       .high = 100,
       .doc =
           "How many waves of the coarsest noise layer fit across the solid's size (see `rough_amplitude`)."},
      [](auto& r) -> auto& { return r.fracture.roughness.frequency; }));
  rows.push_back(with_member(
      {.name = "rough_octaves",
       .type = Type::kInteger,
       .min = 1,
       .max = 6,
       .doc =
           "Number of noise layers, each with twice the frequency and half the amplitude of the previous one. More layers make "
           "more triangles."},
      [](auto& r) -> auto& { return r.fracture.roughness.octaves; }));
  for (std::size_t k = first; k < rows.size(); ++k)
    rows[k].matters = [](const RequestParameters& r) { return r.fracture.roughness.amplitude > 0; };
  return rows;
}

}  // namespace fracture
