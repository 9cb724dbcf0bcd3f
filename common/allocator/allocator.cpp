#include "common/allocator/allocator.hpp"

#ifndef FRACTURE_SANITIZED

#include <jemalloc/jemalloc.h>

#include <string>

// thp: large pages wherever the system hands them out on request. narenas_ratio: at most one arena for each processor; what
// more of them keep, nobody else can use. dirty_decay_ms: what was freed stays for so long, since a page that comes back from the
// system costs more than what is computed in it; muzzy_decay_ms: and then it goes, at once and altogether.
// lg_extent_max_active_fit: what was freed is used again by blocks of any size; by default, a piece that is more than 64 times as
// large as what is asked for waits until it is old, and new memory is taken meanwhile. oversize_threshold: larger blocks go back
// as soon as they are freed; by default those of 8 MiB do, which an answer with rough cuts has several of.
// The environment's MALLOC_CONF comes on top.
extern "C" {
extern const char* malloc_conf;
const char* malloc_conf =
    "thp:always,metadata_thp:auto,narenas_ratio:1.0,dirty_decay_ms:5000,muzzy_decay_ms:0,"
    "lg_extent_max_active_fit:30,oversize_threshold:33554432";
}

namespace fracture {
namespace {

/// For all arenas at once.
std::string of_all_arenas(const char* head, const char* tail) {
  return head + std::to_string(MALLCTL_ARENAS_ALL) + tail;
}

}  // namespace

std::uint64_t free_memory() {
  // Figures are those of the last time that this was written.
  std::uint64_t epoch = 1;
  (void)mallctl("epoch", nullptr, nullptr, &epoch, sizeof(epoch));
  static const std::string dirty = of_all_arenas("stats.arenas.", ".pdirty");
  std::size_t pages = 0, page = 0, size = sizeof(std::size_t);
  if (mallctl(dirty.c_str(), &pages, &size, nullptr, 0) != 0) return 0;
  if (mallctl("arenas.page", &page, &size, nullptr, 0) != 0) return 0;
  return std::uint64_t{pages} * page;
}

void return_free_memory() {
  static const std::string purge = of_all_arenas("arena.", ".purge");
  (void)mallctl(purge.c_str(), nullptr, nullptr, nullptr, 0);
}

void return_old_free_memory() {
  static const std::string decay = of_all_arenas("arena.", ".decay");
  (void)mallctl(decay.c_str(), nullptr, nullptr, nullptr, 0);
}

}  // namespace fracture

#else

namespace fracture {
std::uint64_t free_memory() { return 0; }
void return_free_memory() {}
void return_old_free_memory() {}
}  // namespace fracture

#endif
