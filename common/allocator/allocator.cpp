#include "common/allocator/allocator.hpp"

#ifndef FRACTURE_SANITIZED

#include <jemalloc/jemalloc.h>

#include <string>

// The settings:
// - `thp` uses large pages wherever the system provides them on request.
// - `narenas_ratio` limits arenas to one per processor, because memory kept by an arena cannot be used by the
//   others.
// - `dirty_decay_ms` keeps freed memory for this long, because getting a page back from the system costs more
//   than the computation in it. With `muzzy_decay_ms`, all of it is then returned immediately.
// - `lg_extent_max_active_fit` lets blocks of any size reuse freed memory. By default, a piece more than 64
//   times as large as the request is not reused until it is old, and new memory is taken meanwhile.
// - `oversize_threshold` returns larger blocks as soon as they are freed. By default, this applies to blocks
//   of 8 MiB, and an answer with rough cuts has several of these.
// MALLOC_CONF in the environment overrides these settings.
extern "C" {
extern const char* malloc_conf;
const char* malloc_conf =
    "thp:always,metadata_thp:auto,narenas_ratio:1.0,dirty_decay_ms:5000,muzzy_decay_ms:0,"
    "lg_extent_max_active_fit:30,oversize_threshold:33554432";
}

namespace fracture {
namespace {

/// The name of a control for all arenas together.
std::string of_all_arenas(const char* head, const char* tail) {
  return head + std::to_string(MALLCTL_ARENAS_ALL) + tail;
}

}  // namespace

std::uint64_t free_memory() {
  // Statistics are from the last time that the epoch was written.
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
