// How much memory and how many processors this process may use. The limits come from the machine, from the control group
// (cgroup v2 or v1) of the process, and from the groups above it.
#pragma once

#include <cstdint>
#include <string>

namespace fracture {

/// Returns the lowest memory limit, in bytes, of a control group and all groups above it (memory.max, or
/// memory.limit_in_bytes in version 1). Returns 2^64 - 1 if there is no limit. `membership`: the text of /proc/self/cgroup;
/// `root`: the mount point of the groups, /sys/fs/cgroup.
std::uint64_t memory_limit_of_group(const std::string& membership, const std::string& root);

/// Returns the lowest quota of processor time, in processors, of a control group and all groups above it (cpu.max, or
/// cpu.cfs_quota_us in version 1). Returns 0 if there is no quota.
double cores_of_group(const std::string& membership, const std::string& root);

/// Returns the number of bytes that this process may use: the machine's memory or its group's limit, whichever is lower.
std::uint64_t available_memory();

/// Returns the number of processors that this process may use, at least 1: those in its affinity mask, or its group's
/// quota rounded up, whichever is lower.
int available_cores();

}  // namespace fracture
