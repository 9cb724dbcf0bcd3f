// A finished answer in the format of the cache tiers below memory: the file is an entry's payload, and everything else is
// its metadata. Entries must be checked, because anyone who can write to the disk or to Redis can forge an intact one. The
// content is sent to clients, and later requests that name the answer use its parameters.
#pragma once

#include <memory>
#include <string>

#include "common/base/execution.hpp"
#include "server/cache/disk_cache.hpp"
#include "server/service/result.hpp"

namespace fracture {

/// Returns the metadata of a result. It consists of lines with the format, the mesh digest, the range of the figures in the
/// file (begin and size) and the canonical parameters, followed by the digests of file and figures.
std::string metadata_of(const FractureResult& result);

/// Returns the result in an entry; null if no server can have written it. All lines are checked, the digests must match the
/// bytes, and the parameters must be valid for a request (read_kept_parameters).
std::shared_ptr<const FractureResult> result_in(const StoredEntry& stored,
                                                const Execution& execution = kUninterrupted);

}  // namespace fracture
