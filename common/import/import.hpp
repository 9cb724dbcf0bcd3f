// Imports mesh files: tinygltf reads glTF and GLB, our own readers read OBJ, STL, PLY, OFF and 3MF (DECISION.md), and
// Assimp reads everything else. The input is bytes, and the result is a Mesh or a typed error. No file is ever opened by name: a loader can see only the bytes and
// the additional parts of a multipart upload.
//
//   bytes ──> preflight (own code: magic, lengths, depth, ranges) ──> loader ──> Mesh ──> finish
//                                                                                          (finite, limits)
//
// The preflight is needed because the libraries trust the numbers in a file. tinygltf accepts an accessor with
// 2^31 elements. RapidJSON inside Assimp overflows the stack on 400 KB of '['. Both libraries open any local
// file that a uri names. Our own readers check each number themselves.
// README.md in this folder says which features of each format are kept, applied, dropped or refused.
#pragma once

#include <cstddef>
#include <span>

#include "common/base/error.hpp"
#include "common/import/import_input.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

/// Imports a mesh. Coordinates are those of the file after its own node transforms. Mesh::frame gives their
/// meaning as far as the file or its format defines it (FormatInfo::frame; FBX and 3MF state it themselves).
/// Wedges with identical positions in the file have bit-identical positions here. Texture coordinates follow
/// glTF (v down) for all formats.
/// Errors: kEmptyBody, kMalformedMesh (what, and at which byte or line), kUnsupportedFeature (with its name),
/// kExternalResource, kTooLarge, kNotFinite (a coordinate is NaN or infinite; with the vertex), kEmptyMesh.
Expected<Mesh> import_mesh(std::span<const std::byte> bytes, MeshFormat format, const ImportLimits& limits,
                           std::span<const ImportFile> files = {});

}  // namespace fracture
