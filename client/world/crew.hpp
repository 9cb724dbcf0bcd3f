// Threads that help with a task. Private to this folder.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace fracture::world {

/// The caller and its helpers run the same function together, which must divide its work among its callers.
/// Helpers that have not started when the caller is done are not waited for, so other load on the machine
/// does not delay the caller.
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
  std::size_t open_ = 0, busy_ = 0;  ///< helpers that may still start; helpers at work
  bool over_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace fracture::world
