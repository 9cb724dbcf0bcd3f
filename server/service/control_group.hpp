// What this process may have of its machine: memory and processors, by its control group (cgroup v2 or v1)
// and those above it, and by the machine.
#pragma once

#include <cstdint>
#include <string>

namespace fracture {

/// The least limit in bytes of a control group and those above it (memory.max, or memory.limit_in_bytes of
/// version 1); 2^64 - 1: there is none. `membership`: the text of /proc/self/cgroup; `root`: where the groups
/// are mounted, /sys/fs/cgroup.
std::uint64_t memory_limit_of_group(const std::string& membership, const std::string& root);

/// The least quota of processor time of a control group and those above it, in processors (cpu.max, or
/// cpu.cfs_quota_us of version 1); 0: there is none.
double cores_of_group(const std::string& membership, const std::string& root);

/// Bytes that this process may have: the machine's memory or the limit of its group, whichever is least.
std::uint64_t available_memory();

/// Processors that this process may use, at least 1: its affinity mask, or the quota of its group, rounded
/// up.
int available_cores();

}  // namespace fracture
