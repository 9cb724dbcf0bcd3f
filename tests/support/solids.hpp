// Solids of meshes that tests make themselves.
#pragma once

#include <memory>
#include <utility>

#include "common/mesh/mesh.hpp"
#include "common/solid/solid.hpp"

namespace fracture::test {

/// The result of make_solid: a solid, or the error.
inline Expected<Solid> try_solid(Mesh mesh, const SolidOptions& options = {}) {
  return make_solid(std::make_shared<const Mesh>(std::move(mesh)), options, {});
}

/// The solid of a mesh that must have one. Throws if it has none.
inline Solid solid_of(Mesh mesh, const SolidOptions& options = {}) {
  return try_solid(std::move(mesh), options).value();
}

}  // namespace fracture::test
