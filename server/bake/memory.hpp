// How much memory a bake may use when nobody says it.
#pragma once

#include <cstdint>
#include <string>

namespace fracture::bake {

/// Bytes that this process may have: the machine's memory, or the limit of its control group or of one above
/// it (memory.max, or memory.limit_in_bytes of version 1), whichever is least.
std::uint64_t available_memory();

/// The least limit in bytes of a control group and those above it; 2^64 - 1: there is none. `membership`: the
/// text of /proc/self/cgroup; `root`: where the groups are mounted, /sys/fs/cgroup.
std::uint64_t memory_limit_of_group(const std::string& membership, const std::string& root);

}  // namespace fracture::bake
