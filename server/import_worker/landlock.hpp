// Landlock (linux/landlock.h, since 5.13) by raw system call: a process gives up files and TCP for itself and
// its forks. Debian 12 has no library for it, and its headers know only the first three versions.
#pragma once

namespace fracture {

/// No file can be opened, made, removed or executed any more, and where the kernel knows it (version 4) no
/// TCP port bound or connected. What is open stays usable. Needs PR_SET_NO_NEW_PRIVS. Returns the version
/// that is in force; 0 where this kernel has none or does not let it be used.
int deny_files_by_landlock();

}  // namespace fracture
