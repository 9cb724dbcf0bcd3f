#include "common/base/pages.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>

namespace fracture {

namespace {

void advise_pages(void* memory, std::size_t bytes, int advice) {
  static const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
  const auto begin = reinterpret_cast<std::uintptr_t>(memory);
  const std::uintptr_t first = (begin + page - 1) / page * page, last = (begin + bytes) / page * page;
  if (first < last) madvise(reinterpret_cast<void*>(first), last - first, advice);
}

}  // namespace

void forget_pages(void* memory, std::size_t bytes) { advise_pages(memory, bytes, MADV_DONTNEED); }

void populate_pages(void* memory, std::size_t bytes) { advise_pages(memory, bytes, MADV_POPULATE_WRITE); }

void PagesBehind::through(std::size_t read) {
  constexpr std::size_t kPiece = std::size_t{4} << 20, kMany = std::size_t{32} << 20,
                        kLargestPage = 64u << 10;
  if (bytes_ < kMany) return;
  for (read = std::min(read, bytes_); forgotten_ + kPiece <= read; forgotten_ += kPiece) {
    // A page that spans two pieces is not completely inside either. So each piece begins within the previous
    // one.
    const std::size_t before = std::min(forgotten_, kLargestPage);
    forget_pages(memory_ + forgotten_ - before, before + kPiece);
  }
}

}  // namespace fracture
