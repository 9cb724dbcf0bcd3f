// What an import worker hands back, as bytes: a Mesh, bit for bit, or an Error. The worker runs foreign
// parsers over hostile files, so the server takes nothing on trust: decode_reply() checks every length before
// it allocates, and every promise that mesh.hpp and MeshBuilder make.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/import/import_input.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

std::vector<std::byte> encode_reply(const Expected<Mesh>& imported);

/// Thrown for bytes that no worker of ours writes; says which promise is broken.
class BadReply : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The worker's answer, a Mesh or its typed error. Throws BadReply.
Expected<Mesh> decode_reply(std::span<const std::byte> bytes, const ImportLimits& limits);

}  // namespace fracture
