#include "common/base/scratch.hpp"

#include <algorithm>

#include "common/base/helper_threads.hpp"

namespace fracture {
namespace {

std::vector<base_detail::KeptByThread*>& kept_by_this_thread() {
  thread_local std::vector<base_detail::KeptByThread*> all;
  return all;
}

}  // namespace

namespace base_detail {

// The list is constructed before the objects that register in it, so it outlives them.
KeptByThread::KeptByThread() { kept_by_this_thread().push_back(this); }
KeptByThread::~KeptByThread() { std::erase(kept_by_this_thread(), this); }

void trim_own_scratch() {
  if (scratch_of_this_thread() <= kScratchPerThread) return;
  for (KeptByThread* kept : kept_by_this_thread()) kept->release();
}

}  // namespace base_detail

std::size_t scratch_of_this_thread() {
  std::size_t sum = 0;
  for (const base_detail::KeptByThread* kept : kept_by_this_thread()) sum += kept->bytes();
  return sum;
}

void trim_scratch() {
  base_detail::trim_own_scratch();
  base_detail::trim_helpers();
}

}  // namespace fracture
