// The bytes of an import worker's reply: a Mesh, preserved bit for bit, or an Error. The worker runs third-party parsers on
// hostile files, so the server trusts nothing. decode_reply() checks every length before it allocates memory, and checks all
// guarantees that mesh.hpp and MeshBuilder give.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/import/import_input.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

std::vector<std::byte> encode_reply(const Expected<Mesh>& imported);

/// Thrown for bytes that none of our workers would write. Says which guarantee is broken.
class BadReply : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Decodes a worker's reply. Returns the mesh or the worker's typed error. Throws BadReply and Interrupted.
Expected<Mesh> decode_reply(std::span<const std::byte> bytes, const ImportLimits& limits,
                            const Execution& execution = kUninterrupted);

}  // namespace fracture
