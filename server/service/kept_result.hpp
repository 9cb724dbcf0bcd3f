// A finished answer as the tiers below memory keep it: the file is the payload of an entry, all else its metadata. Whoever can
// write to the disk or to Redis may have made an intact entry. What is read here is given to clients, and taken for the
// parameters of a request that names the answer.
#pragma once

#include <memory>
#include <string>

#include "common/base/execution.hpp"
#include "server/cache/disk_cache.hpp"
#include "server/service/result.hpp"

namespace fracture {

/// Lines: format, mesh digest, where the figures stand in the file (begin and size), the canonical parameters; then the
/// digests of file and figures.
std::string metadata_of(const FractureResult& result);

/// Null for an entry that no server has written: every line is checked, the digests are those of the bytes, and the
/// parameters are such as a request may have (read_kept_parameters).
std::shared_ptr<const FractureResult> result_in(const StoredEntry& stored,
                                                const Execution& execution = kUninterrupted);

}  // namespace fracture
