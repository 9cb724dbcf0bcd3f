// Landlock (linux/landlock.h, since Linux 5.13): a process gives up access to files and TCP for itself and its forks. This
// code uses raw system calls, because Debian 12 has no library for Landlock, and its headers know only the first three
// versions.
#pragma once

namespace fracture {

/// Denies opening, creating, removing and executing files. From Landlock version 4 on, also denies binding and connecting TCP
/// ports. Open descriptors stay usable. Requires PR_SET_NO_NEW_PRIVS. Returns the version in force; 0 if this kernel does not
/// have Landlock or does not allow it.
int deny_files_by_landlock();

}  // namespace fracture
