// Writes fragments as one file that standard tools can read: glTF 2.0 core without required extensions. Data, bonds and the
// certificate are in extras. The same fragments and options give the same bytes.
//
//   scene ── root (translation = offset of the source, if any; extras.fracture: report, certificate, bonds)
//             ├─ fragment 0  translation = pivot; extras.fracture: id, volume, …; rigid body;
//             │   │          mesh 0: exterior primitives, interior
//             │   ├─ colliders of a compound, UCX_ hulls: identity, no extras
//             │   └─ sheets that the fragment carries, if any: identity, no extras
//             ├─ fragment 1 …
//             └─ group of a node of the source, if there are several: its fragments, and further groups (group_nodes.hpp)
//   scene "Intact", if requested: the solid before it breaks (intact_scene.hpp)
//
// A fragment that is a whole instance of a mesh refers to a mesh that several of them share (pipeline/instanced_bodies.hpp). Its
// node has a rotation and a uniform scale, and I2 does not hold for it: its vertices are rounded before the node's transform.
//
// All fragments share one bufferView for each attribute and one for the indices. The primitives of a mesh
// share their attribute accessors. World positions are float32(local) + float32(translation), exact by
// construction (I2), and are those below the root. Collision hulls are separate meshes that follow those of the fragments.
//
// Images are copied byte for byte, with one exception: some PNG chunks are left out (image_bytes.hpp), because glTF
// tells readers to ignore them and the Khronos validator warns about them. Pixels stay unchanged.
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

/// Which physics extension the fragments have. It is always optional: listed only in extensionsUsed.
enum class Physics {
  kKhr,   ///< KHR_physics_rigid_bodies: motion with mass, centre and inertia; convex colliders
          ///< (khr_physics.hpp)
  kOmi,   ///< OMI_physics_body and OMI_physics_shape, for Godot (omi_physics.hpp)
  kNone,  ///< neither
};

/// Whether hulls also get the names that Unreal recognizes as collision geometry.
enum class UeCollision {
  kNone,
  kUcx,  ///< a node UCX_<fragment>_NN for each hull (ue_collision.hpp)
};

/// Contact properties of a material.
struct ContactSurface {
  double friction = 0.6;     ///< static and dynamic
  double restitution = 0.1;  ///< 0 … 1
  friend bool operator==(const ContactSurface&, const ContactSurface&) = default;
};

/// Options for everything in the file that is not geometry. The file contains no time stamp and no host name. So identical
/// requests give identical bytes.
struct GltfOptions {
  nlohmann::json parameters =
      nlohmann::json::object();  ///< the canonical request, for asset.extras and extras.fracture
  std::string mesh_digest;       ///< "sha256:…" of the input bytes
  int algorithm = 1;             ///< version of the algorithm
  double density = 1000;         ///< kg/m³, for the mass of each fragment
  /// Colliders need FracturedSolid::hulls; a fragment without hulls is a body without a collider.
  Physics physics = Physics::kKhr;
  UeCollision ue_collision = UeCollision::kNone;
  double friction = 0.6;     ///< static and dynamic
  double restitution = 0.1;  ///< 0 … 1
  /// Surfaces of parts that are made of other materials. `surface_of_part`: 0 for the two members above, otherwise the place in
  /// `surfaces`, from 1. May be empty.
  std::vector<ContactSurface> surfaces{};
  std::vector<std::uint32_t> surface_of_part{};
  double bond_strength = 1e6;  ///< Pa: a bond withstands its area times this in tension
  bool mesh_manifold = true;   ///< EXT_mesh_manifold on every fragment with a topology (mesh_manifold.hpp)
  /// The materials of the cut faces. Their names should contain "Interior", because tools recognize cut faces by it.
  /// Textures are indices into the source's.
  InteriorMaterials interior{.materials = {plain_interior_material()}};
  ExteriorMaterials exterior{};
};

/// File format of the fragments.
enum class OutputFormat {
  kGlb,
  kGltf,  ///< model/gltf+json: JSON text with the buffer in a data URI
};

/// A range of bytes in a file. Empty if `size` is 0.
struct TextRange {
  std::uint64_t at = 0, size = 0;
};

struct GltfFile {
  std::vector<std::uint8_t> bytes;
  TextRange figures;  ///< position of the root's `extras.fracture` object (fracture_extras.hpp)
};

/// Throws InternalError if a companion has a different number of fragments than the set, or the file would exceed 4 GiB.
/// Also throws it if a fragment is inconsistent (attribute lengths, index ranges, primitives that do not cover the indices,
/// a topology with an index out of range). Throws Interrupted.
GltfFile write_file(const FracturedSolid& fractured, const GltfOptions& options, OutputFormat format,
                    const Execution& execution = {});
/// Return only the bytes. Throw the same exceptions as write_file().
std::vector<std::uint8_t> write_glb(const FracturedSolid& fractured, const GltfOptions& options,
                                    const Execution& execution = {});
std::vector<std::uint8_t> write_gltf(const FracturedSolid& fractured, const GltfOptions& options,
                                     const Execution& execution = {});
/// Returns the `extras.fracture` object of the root node (fracture_extras.hpp).
nlohmann::json fracture_extras(const FracturedSolid& fractured, const GltfOptions& options);

}  // namespace fracture
