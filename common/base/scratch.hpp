// Working memory that threads keep from one use to the next, since fresh memory costs more than the work done
// in it, and that is given back after a large computation.
#pragma once

#include <cstddef>
#include <vector>

#include "common/base/heap_bytes.hpp"

namespace fracture {

namespace base_detail {

/// Something that the thread in which it was made keeps.
class KeptByThread {
 public:
  KeptByThread();
  virtual ~KeptByThread();
  KeptByThread(const KeptByThread&) = delete;
  KeptByThread& operator=(const KeptByThread&) = delete;
  virtual std::size_t bytes() const = 0;
  virtual void release() = 0;
};

template <class T>
class Kept final : public KeptByThread {
 public:
  T value;
  std::size_t bytes() const override { return value.bytes(); }
  void release() override { value.release(); }
};

}  // namespace base_detail

/// The calling thread's T: default-constructed at first, kept until the thread ends. T::bytes() says how much
/// it holds, T::release() frees that. One user at a time.
template <class T>
T& thread_scratch() {
  thread_local base_detail::Kept<T> kept;
  return kept.value;
}

/// A thread that keeps more than this gives all of it back when scratch is trimmed.
inline constexpr std::size_t kScratchPerThread = std::size_t{8} << 20;

/// Trims the scratch of the calling thread, and makes the helper threads (execution.hpp) trim theirs as soon
/// as they are idle. Cheap where nothing is large. At the end of a computation, while the calling thread uses
/// none of it.
void trim_scratch();

/// What the calling thread keeps, in bytes.
std::size_t scratch_of_this_thread();

/// Trims at the end of its life.
class ScratchTrimmer {
 public:
  ScratchTrimmer() = default;
  ~ScratchTrimmer() { trim_scratch(); }
  ScratchTrimmer(const ScratchTrimmer&) = delete;
  ScratchTrimmer& operator=(const ScratchTrimmer&) = delete;
};

/// For T::bytes() and T::release().
template <class... Items>
std::size_t bytes_of_vectors(const std::vector<Items>&... vectors) {
  return (std::size_t{0} + ... + heap(vectors));
}
template <class... Items>
void release_vectors(std::vector<Items>&... vectors) {
  ((vectors = std::vector<Items>()), ...);
}

}  // namespace fracture
