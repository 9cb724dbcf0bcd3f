// A load generator with plain threads. Closed loop: each client sends its next request when it has an answer.
// Open loop: requests leave by the clock, whether the server keeps up or not, which is how an overload
// happens.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/support/raw_client.hpp"

namespace fracture::bench {

using Clock = std::chrono::steady_clock;

inline double milliseconds(Clock::duration d) { return std::chrono::duration<double, std::milli>(d).count(); }

struct Sample {
  int status = 0;  ///< 0: no answer
  double milliseconds = 0;
  bool retry_after = false;
};

/// The q-quantile by nearest rank; 0 for no values.
inline double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(values.size())));
  return values[std::clamp<std::size_t>(rank, 1, values.size()) - 1];
}

/// Makes the bytes of the n-th request.
using MakeRequest = std::function<std::string(std::size_t n)>;

/// A keep-alive connection. It connects again after a close.
class Client {
 public:
  explicit Client(std::uint16_t port) : port_(port) {}
  Sample ask(const std::string& request) {
    const Clock::time_point start = Clock::now();
    Sample sample;
    try {
      if (!connection_) connection_ = std::make_unique<test::RawClient>(port_);
      connection_->send(request);
      const auto reply = connection_->receive();
      if (reply) {
        sample.status = reply->status;
        sample.retry_after = !reply->header("retry-after").empty();
      }
      if (!reply || reply->header("connection") == "close") connection_.reset();
    } catch (const std::runtime_error&) {
      connection_.reset();
    }
    sample.milliseconds = milliseconds(Clock::now() - start);
    return sample;
  }

 private:
  std::uint16_t port_;
  std::unique_ptr<test::RawClient> connection_;
};

struct Load {
  std::vector<Sample> samples;
  double seconds = 0;
  std::size_t late =
      0;  ///< open loop: number of requests that left over 10 ms late because every client was busy

  std::vector<double> latencies(const std::function<bool(const Sample&)>& which) const {
    std::vector<double> values;
    for (const Sample& s : samples)
      if (which(s)) values.push_back(s.milliseconds);
    return values;
  }
  std::size_t count(int status) const {
    return static_cast<std::size_t>(
        std::count_if(samples.begin(), samples.end(), [&](const Sample& s) { return s.status == status; }));
  }
  double rate(int status) const { return static_cast<double>(count(status)) / seconds; }
};

/// `next(n, due)` sets the time of a client's next request. It returns false at the end of the load.
inline Load run_load(std::uint16_t port, int clients, const MakeRequest& make,
                     const std::function<bool(std::size_t n, Clock::time_point& due)>& next) {
  Load load;
  std::mutex mutex;
  std::atomic<std::size_t> counter{0}, late{0};
  std::vector<std::thread> threads;
  const Clock::time_point start = Clock::now();
  for (int c = 0; c < clients; ++c)
    threads.emplace_back([&] {
      Client client(port);
      std::vector<Sample> mine;
      for (;;) {
        const std::size_t n = counter++;
        Clock::time_point due = Clock::now();
        if (!next(n, due)) break;
        std::this_thread::sleep_until(due);
        if (Clock::now() - due > std::chrono::milliseconds(10)) ++late;
        mine.push_back(client.ask(make(n)));
      }
      const std::lock_guard lock(mutex);
      load.samples.insert(load.samples.end(), mine.begin(), mine.end());
    });
  for (std::thread& thread : threads) thread.join();
  load.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  load.late = late;
  return load;
}

inline Load closed_loop(std::uint16_t port, int clients, std::chrono::milliseconds duration,
                        const MakeRequest& make) {
  const Clock::time_point end = Clock::now() + duration;
  return run_load(port, clients, make, [end](std::size_t, Clock::time_point&) { return Clock::now() < end; });
}

inline Load closed_loop_count(std::uint16_t port, int clients, std::size_t count, const MakeRequest& make) {
  return run_load(port, clients, make, [count](std::size_t n, Clock::time_point&) { return n < count; });
}

inline Load open_loop(std::uint16_t port, int clients, std::chrono::milliseconds duration, double per_second,
                      const MakeRequest& make) {
  const Clock::time_point start = Clock::now();
  return run_load(port, clients, make, [=](std::size_t n, Clock::time_point& due) {
    due = start +
          std::chrono::microseconds(static_cast<std::int64_t>(1e6 * static_cast<double>(n) / per_second));
    return due < start + duration;
  });
}

}  // namespace fracture::bench
