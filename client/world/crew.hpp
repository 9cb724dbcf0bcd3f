// Threads that help with a piece of work. Private to this folder.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace fracture::world {

/// The caller and so many helpers do the same work together: it has to share itself out among those who call it. Helpers
/// that have not begun when the caller is done are not waited for, so that a machine that is busy elsewhere costs nothing.
class Crew {
 public:
  explicit Crew(std::size_t helpers);
  ~Crew();
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;
  void run(const std::function<void()>& work);

 private:
  void serve();

  std::mutex mutex_;
  std::condition_variable begins_, ends_;
  const std::function<void()>* work_ = nullptr;
  std::size_t open_ = 0, busy_ = 0;  ///< helpers that may still begin; that are at work
  bool over_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace fracture::world
