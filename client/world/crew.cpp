#include "client/world/crew.hpp"

namespace fracture::world {

Crew::Crew(std::size_t helpers) {
  for (std::size_t k = 0; k < helpers; ++k) threads_.emplace_back([this] { serve(); });
}

Crew::~Crew() {
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
  }
  begins_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void Crew::serve() {
  std::unique_lock lock(mutex_);
  for (;;) {
    begins_.wait(lock, [this] { return over_ || open_ > 0; });
    if (over_) return;
    --open_;
    ++busy_;
    const std::function<void()>& work = *work_;
    lock.unlock();
    work();
    lock.lock();
    if (--busy_ == 0) ends_.notify_one();
  }
}

void Crew::run(const std::function<void()>& work) {
  {
    const std::lock_guard lock(mutex_);
    work_ = &work;
    open_ = threads_.size();
  }
  begins_.notify_all();
  work();
  std::unique_lock lock(mutex_);
  open_ = 0;
  ends_.wait(lock, [this] { return busy_ == 0; });
}

}  // namespace fracture::world
