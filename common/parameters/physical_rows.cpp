// Rows for the physics of fragments and the strength of their bonds.
#include <utility>

#include "common/parameters/fields.hpp"
#include "common/parameters/rows.hpp"

namespace fracture {

using parameter_fields::with_member;

std::vector<ParameterSpec> physical_parameter_rows() {
  std::vector<ParameterSpec> rows;
  ParameterSpec density = with_member(
      {.name = "density",
       .type = Type::kNumber,
       .unit = "kg/m³",
       .low = 1e-3,
       .high = 1e6,
       .doc = "Density of the fragments."},
      [](auto& r) -> auto& { return r.physical.density; });
  density.get = [get = density.get](const RequestParameters& r, const ParameterSpec& s) {
    return r.mass ? nlohmann::json() : get(r, s);
  };
  rows.push_back(std::move(density));
  rows.push_back(with_member(
      {.name = "mass",
       .type = Type::kNumber,
       .unit = "kg",
       .low = 1e-9,
       .high = 1e15,
       .doc = "Total mass of all fragments, instead of `density`."},
      [](auto& r) -> auto& { return r.mass; }));
  rows.push_back(with_member(
      {.name = "friction",
       .type = Type::kNumber,
       .low = 0,
       .high = 10,
       .doc = "Friction coefficient, static and dynamic."},
      [](auto& r) -> auto& { return r.physical.friction; }));
  rows.push_back(with_member(
      {.name = "restitution",
       .type = Type::kNumber,
       .low = 0,
       .high = 1,
       .doc = "How much the fragments bounce."},
      [](auto& r) -> auto& { return r.physical.restitution; }));
  rows.push_back(with_member(
      {.name = "bond_strength",
       .type = Type::kNumber,
       .unit = "Pa",
       .low = 0,
       .high = 1e12,
       .doc = "Stress at which a bond (the area that two fragments share) breaks."},
      [](auto& r) -> auto& { return r.physical.bond_strength; }));
  rows.push_back(with_member(
      {.name = "contact_strength",
       .type = Type::kNumber,
       .low = 0,
       .high = 1000,
       .doc =
           "Strength of bonds between fragments of different parts: this factor times `bond_strength` times the contact "
           "area. 0: no such bonds."},
      [](auto& r) -> auto& { return r.fracture.contact_strength; }));
  rows.back().matters = [](const RequestParameters& r) { return r.fracture.contact_strength != 1; };
  return rows;
}

}  // namespace fracture
