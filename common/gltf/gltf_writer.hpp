// Fragments out: one file that standard tools read (glTF 2.0 core, nothing required), with figures, bonds and
// certificate in extras. The same fragments and options give the same bytes.
//
//   scene ── root (identity; extras.fracture: report, certificate, bonds)
//             ├─ fragment 0  translation = pivot; extras.fracture: id, volume, …; rigid body;
//             │   │          mesh 0: exterior primitives, interior
//             │   └─ colliders of a compound, UCX_ hulls: identity, no extras
//             └─ fragment 1 …
//   scene "Intact", if it was asked for: the solid before it breaks (intact_scene.hpp)
//
// All fragments share one bufferView for each attribute and one for the indices; the primitives of a mesh
// share their attribute accessors. World positions are float32(local) + float32(translation), exact by
// construction (I2). Collision hulls are meshes of their own behind those of the fragments.
//
// Images pass through byte for byte, with one exception: chunks of a PNG that glTF tells readers to ignore
// and that the Khronos validator therefore warns of (image_bytes.hpp) are left out; pixels are untouched.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/base/execution.hpp"
#include "common/gltf/exterior_material.hpp"
#include "common/gltf/interior_material.hpp"
#include "common/pipeline/fractured_solid.hpp"

namespace fracture {

/// Which physics extension the fragments carry (always optional: in extensionsUsed only).
enum class Physics {
  kKhr,   ///< KHR_physics_rigid_bodies: motion with mass, centre and inertia; convex colliders
          ///< (khr_physics.hpp)
  kOmi,   ///< OMI_physics_body and OMI_physics_shape, for Godot (omi_physics.hpp)
  kNone,  ///< neither
};

/// Hulls under the names by which Unreal takes them for collision geometry.
enum class UeCollision {
  kNone,
  kUcx,  ///< a node UCX_<fragment>_NN for each hull (ue_collision.hpp)
};

/// What the file says beside the geometry. No time stamps, no host names: identical requests give identical
/// bytes.
struct GltfOptions {
  nlohmann::json parameters =
      nlohmann::json::object();  ///< the canonical request, for asset.extras and extras.fracture
  std::string mesh_digest;       ///< "sha256:…" of the input bytes
  int algorithm = 1;             ///< version of the algorithm
  double density = 1000;         ///< kg/m³, for the mass of each fragment
  /// Colliders need FracturedSolid::hulls; a fragment without hulls is a body without a collider.
  Physics physics = Physics::kKhr;
  UeCollision ue_collision = UeCollision::kNone;
  double friction = 0.6;       ///< static and dynamic
  double restitution = 0.1;    ///< 0 … 1
  double bond_strength = 1e6;  ///< Pa: a bond's area times this is the tension it withstands
  bool mesh_manifold = true;   ///< EXT_mesh_manifold on every fragment with a topology (mesh_manifold.hpp)
  /// The materials of the cut faces; their names should contain "Interior" (that is how tools tell cut faces from
  /// the outside). Textures are indices into the source's.
  InteriorMaterials interior{.materials = {plain_interior_material()}};
  ExteriorMaterials exterior{};
};

/// How the fragments are written down.
enum class OutputFormat {
  kGlb,
  kGltf,  ///< model/gltf+json: JSON text with the buffer in a data URI
};

/// Bytes of a file; none where `size` is 0.
struct TextRange {
  std::uint64_t at = 0, size = 0;
};

struct GltfFile {
  std::vector<std::uint8_t> bytes;
  TextRange figures;  ///< the `extras.fracture` object of the root node (fracture_extras.hpp)
};

/// Throws InternalError when a fragment contradicts its own description (attribute lengths, index ranges,
/// primitives that do not cover the indices, a topology that names what is not there), a companion has another number of
/// fragments than the set, or the file would pass 4 GiB; Interrupted.
GltfFile write_file(const FracturedSolid& fractured, const GltfOptions& options, OutputFormat format,
                    const Execution& execution = {});
/// The bytes alone. Throw as write_file().
std::vector<std::uint8_t> write_glb(const FracturedSolid& fractured, const GltfOptions& options,
                                    const Execution& execution = {});
std::vector<std::uint8_t> write_gltf(const FracturedSolid& fractured, const GltfOptions& options,
                                     const Execution& execution = {});
/// The `extras.fracture` object of the root node (fracture_extras.hpp).
nlohmann::json fracture_extras(const FracturedSolid& fractured, const GltfOptions& options);

}  // namespace fracture
