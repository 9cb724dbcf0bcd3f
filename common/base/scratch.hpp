// Working memory that threads keep between uses, because fresh memory costs more than the work done in it. It
// is freed after a large computation.
#pragma once

#include <cstddef>
#include <vector>

#include "common/base/heap_bytes.hpp"

namespace fracture {

namespace base_detail {

/// An object kept by the thread that constructed it.
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

/// The calling thread's T: default-constructed on first use, and kept until the thread ends. T::bytes()
/// returns its size, and T::release() frees its memory. Only one user at a time.
template <class T>
T& thread_scratch() {
  thread_local base_detail::Kept<T> kept;
  return kept.value;
}

/// A thread whose scratch exceeds this frees all of it when scratch is trimmed.
inline constexpr std::size_t kScratchPerThread = std::size_t{8} << 20;

/// Trims the scratch of the calling thread, and makes the helper threads (execution.hpp) trim theirs as soon
/// as they are idle. Cheap if nothing is large. Call it at the end of a computation, when the calling thread
/// uses no scratch.
void trim_scratch();

/// Bytes of scratch that the calling thread keeps.
std::size_t scratch_of_this_thread();

/// Trims scratch when it is destroyed.
class ScratchTrimmer {
 public:
  ScratchTrimmer() = default;
  ~ScratchTrimmer() { trim_scratch(); }
  ScratchTrimmer(const ScratchTrimmer&) = delete;
  ScratchTrimmer& operator=(const ScratchTrimmer&) = delete;
};

/// Helpers to implement T::bytes() and T::release().
template <class... Items>
std::size_t bytes_of_vectors(const std::vector<Items>&... vectors) {
  return (std::size_t{0} + ... + heap(vectors));
}
template <class... Items>
void release_vectors(std::vector<Items>&... vectors) {
  ((vectors = std::vector<Items>()), ...);
}

}  // namespace fracture
