#include "server/import_worker/landlock.hpp"

#include <linux/types.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>

// These system calls have the same numbers on all architectures.
#ifndef SYS_landlock_create_ruleset
#define SYS_landlock_create_ruleset 444
#define SYS_landlock_restrict_self 446
#endif

namespace fracture {
namespace {

/// struct landlock_ruleset_attr. The kernel accepts any prefix that it knows.
struct Ruleset {
  std::uint64_t files, network;
};
constexpr unsigned kVersionFlag = 1;

/// Returns all file rights that this version knows. Newer versions have added further bits.
std::uint64_t file_rights(long version) {
  const int count = version >= 5 ? 16 : version >= 3 ? 15 : version == 2 ? 14 : 13;
  return (std::uint64_t{1} << count) - 1;
}

}  // namespace

int deny_files_by_landlock() {
  const long version = ::syscall(SYS_landlock_create_ruleset, nullptr, std::size_t{0}, kVersionFlag);
  if (version < 1) return 0;
  constexpr std::uint64_t kBindAndConnect = 3;
  const bool network = version >= 4;
  const Ruleset everything{file_rights(version), network ? kBindAndConnect : 0};
  const long ruleset = ::syscall(SYS_landlock_create_ruleset, &everything,
                                 network ? sizeof everything : sizeof everything.files, 0u);
  if (ruleset < 0) return 0;
  const bool done = ::syscall(SYS_landlock_restrict_self, static_cast<int>(ruleset), 0u) == 0;
  ::close(static_cast<int>(ruleset));
  return done ? static_cast<int>(version) : 0;
}

}  // namespace fracture
