#include "server/bake/memory.hpp"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>

namespace fracture::bake {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();

/// The number in the file; kNoLimit for "max" and where there is no such file.
std::uint64_t limit_in(const fs::path& file) {
  std::ifstream stream(file);
  std::uint64_t limit = 0;
  return stream >> limit ? limit : kNoLimit;
}

/// From the group up to the root. A process in a container sees its own group as the root, whatever its
/// membership says, so that groups which are not there are passed over.
std::uint64_t least_limit(const fs::path& root, const fs::path& group, const char* file) {
  std::uint64_t least = limit_in(root / file);
  fs::path at = root;
  for (const fs::path& part : group.relative_path()) {
    at /= part;
    least = std::min(least, limit_in(at / file));
  }
  return least;
}

}  // namespace

std::uint64_t memory_limit_of_group(const std::string& membership, const std::string& root) {
  std::uint64_t least = kNoLimit;
  std::istringstream lines(membership);
  for (std::string line;
       std::getline(lines, line);) {  // "0::/group" of version 2, "7:memory:/group" of version 1
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    std::string controllers = line.substr(first, second - first);
    controllers.front() = ',';
    controllers += ',';
    const std::string group = line.substr(second + 1);
    if (controllers == ",,") least = std::min(least, least_limit(root, group, "memory.max"));
    if (controllers.find(",memory,") != std::string::npos)
      least = std::min(least, least_limit(fs::path(root) / "memory", group, "memory.limit_in_bytes"));
  }
  return least;
}

std::uint64_t available_memory() {
  const long pages = ::sysconf(_SC_PHYS_PAGES), page = ::sysconf(_SC_PAGESIZE);
  const std::uint64_t machine =
      pages > 0 && page > 0 ? static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page) : kNoLimit;
  std::ifstream file("/proc/self/cgroup");
  const std::string membership{std::istreambuf_iterator<char>(file), {}};
  return std::min(machine, memory_limit_of_group(membership, "/sys/fs/cgroup"));
}

}  // namespace fracture::bake
