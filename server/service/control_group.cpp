#include "server/service/control_group.hpp"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <sstream>
#include <thread>

namespace fracture {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRoot = "/sys/fs/cgroup";
constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();
constexpr double kNoQuota = std::numeric_limits<double>::infinity();

std::string membership() {
  std::ifstream file("/proc/self/cgroup");
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Reads the number in the file. Returns false if the file has no number ("max") or does not exist.
template <class Number>
bool read_number(const fs::path& file, Number& number) {
  std::ifstream stream(file);
  return static_cast<bool>(stream >> number);
}

/// Calls look(folder) for the group and all groups above it. A process in a container sees its own group as the
/// root, whatever its membership says, so some of these folders may not exist. Reading from them yields no limit.
void up_to_root(const fs::path& root, const fs::path& group,
                const std::function<void(const fs::path&)>& look) {
  look(root);
  fs::path at = root;
  for (const fs::path& part : group.relative_path()) look(at /= part);
}

/// Calls look(folder, version) for every group folder that may limit `controller`.
void each_group(const std::string& membership, const fs::path& root, const std::string& controller,
                const std::function<void(const fs::path&, int version)>& look) {
  std::istringstream lines(membership);
  for (std::string line;
       std::getline(lines, line);) {  // version 2: "0::/group"; version 1: "7:memory:/group"
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    std::string controllers = line.substr(first, second - first);
    controllers.front() = ',';
    controllers += ',';
    const std::string group = line.substr(second + 1);
    if (controllers == ",,") up_to_root(root, group, [&](const fs::path& folder) { look(folder, 2); });
    if (controllers.find("," + controller + ",") != std::string::npos)
      up_to_root(root / controller, group, [&](const fs::path& folder) { look(folder, 1); });
  }
}

/// Returns the quota divided by the period, which are both in microseconds.
double cores_in(const fs::path& folder, int version) {
  double quota = 0, period = 0;
  if (version == 2) {
    std::ifstream both(folder / "cpu.max");  // "max 100000" or "150000 100000"
    if (!(both >> quota >> period)) return kNoQuota;
  } else if (!read_number(folder / "cpu.cfs_quota_us", quota) ||
             !read_number(folder / "cpu.cfs_period_us", period)) {
    return kNoQuota;
  }
  return quota > 0 && period > 0 ? quota / period : kNoQuota;
}

}  // namespace

std::uint64_t memory_limit_of_group(const std::string& membership, const std::string& root) {
  std::uint64_t least = kNoLimit;
  each_group(membership, root, "memory", [&](const fs::path& folder, int version) {
    std::uint64_t limit = 0;
    if (read_number(folder / (version == 2 ? "memory.max" : "memory.limit_in_bytes"), limit))
      least = std::min(least, limit);
  });
  return least;
}

double cores_of_group(const std::string& membership, const std::string& root) {
  double least = kNoQuota;
  each_group(membership, root, "cpu", [&](const fs::path& folder, int version) {
    least = std::min(least, cores_in(folder, version));
  });
  return least == kNoQuota ? 0 : least;
}

std::uint64_t available_memory() {
  const long pages = ::sysconf(_SC_PHYS_PAGES), page = ::sysconf(_SC_PAGESIZE);
  const std::uint64_t machine =
      pages > 0 && page > 0 ? static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page) : kNoLimit;
  return std::min(machine, memory_limit_of_group(membership(), kRoot));
}

int available_cores() {
  int cores = static_cast<int>(std::thread::hardware_concurrency());
  cpu_set_t mask;
  if (sched_getaffinity(0, sizeof mask, &mask) == 0) cores = CPU_COUNT(&mask);
  if (const double quota = cores_of_group(membership(), kRoot); quota > 0)
    cores = static_cast<int>(std::min<double>(cores, std::ceil(quota)));
  return std::max(1, cores);
}

}  // namespace fracture
