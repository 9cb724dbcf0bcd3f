// A std::vector for large arrays that are read at random: 64-byte aligned, and on Linux in transparent huge
// pages, which removes most TLB misses of a walk through hundreds of megabytes (measured in DECISION.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <vector>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace fracture {

inline constexpr std::size_t kHugePage = std::size_t{1} << 21;

/// Asks for huge pages in the whole ones of a range not yet touched; a hint, never an error.
inline void advise_huge_pages([[maybe_unused]] void* data, [[maybe_unused]] std::size_t bytes) {
#ifdef __linux__
  const auto begin = (reinterpret_cast<std::uintptr_t>(data) + kHugePage - 1) / kHugePage * kHugePage;
  const auto end = (reinterpret_cast<std::uintptr_t>(data) + bytes) / kHugePage * kHugePage;
  if (begin < end) ::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
#endif
}

template <class T>
struct HugePageAllocator {
  using value_type = T;

  HugePageAllocator() = default;
  template <class U>
  HugePageAllocator(const HugePageAllocator<U>&) {}  // NOLINT: converting by contract of allocators

  static std::size_t alignment(std::size_t count) {
    return count * sizeof(T) >= 2 * kHugePage ? kHugePage : std::size_t{64};
  }
  T* allocate(std::size_t count) {
    void* p = ::operator new (count * sizeof(T), std::align_val_t{alignment(count)});
    if (alignment(count) == kHugePage) advise_huge_pages(p, count * sizeof(T));
    return static_cast<T*>(p);
  }
  void deallocate(T* p, std::size_t count) { ::operator delete (p, std::align_val_t{alignment(count)}); }
  friend bool operator==(const HugePageAllocator&, const HugePageAllocator&) { return true; }
};

template <class T>
using HugePageVector = std::vector<T, HugePageAllocator<T>>;

}  // namespace fracture
