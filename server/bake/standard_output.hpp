// Standard output, which may be a pipe whose reader is slow or gone.
#pragma once

#include <cstddef>
#include <span>
#include <stop_token>

namespace fracture::bake {

/// Writes all bytes; returns false and sets errno on failure. errno is EPIPE if the reader has closed the
/// pipe (SIGPIPE is ignored here), and ECANCELED if a stop was requested while waiting for the reader.
bool write_standard_output(std::span<const std::byte> bytes, const std::stop_token& stop);

}  // namespace fracture::bake
