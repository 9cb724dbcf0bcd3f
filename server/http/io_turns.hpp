// Decides which client's request an I/O thread handles next. Asio gives turns to connections, in the order of
// their events. So a client with 60 connections would get 60 turns for each turn of a client with one.
//
// A request begins at once if a thread is free and no request waits. Otherwise it waits in a fair queue
// (service/fair_queue.hpp). The client that has used the least time of the I/O threads comes next.
//
// As many requests can begin as there are I/O threads. A thread counts as free again after all events that
// were ready when its request was handled (`later`). Among them are the next requests of other connections,
// so these wait in this queue and not in Asio's. If many events were ready (parts of bodies and answers), more
// requests may begin, so that these do not starve.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>

#include "server/service/fair_queue.hpp"

namespace fracture::http {

/// Thread-safe. Must outlive its places.
class IoTurns {
  struct Waiting {
    std::function<void()> wake;
    Flow flow;
    bool granted = false;
    bool used = false;  ///< the turn was taken or passed on
  };
  struct Item {
    std::uint64_t id;
    double cost;
    Flow flow;
    std::chrono::steady_clock::time_point arrival;
    std::shared_ptr<Waiting> waiting;
  };

 public:
  using Call = std::function<void()>;

  /// `later`: runs a call on an I/O thread, after all handlers that are ready. Never runs it before it
  /// returns.
  IoTurns(std::size_t threads, std::function<void(Call)> later)
      : threads_(threads), later_(std::move(later)) {}
  IoTurns(const IoTurns&) = delete;
  IoTurns& operator=(const IoTurns&) = delete;

  /// A request that waits for its turn. Its destructor leaves the queue, and passes on a turn that was not
  /// taken.
  class Place {
   public:
    Place(Place&& other) noexcept = default;
    Place& operator=(Place&&) = delete;
    ~Place();
    bool granted() const;
    /// Takes the turn, which lasts until this thread's end_turn() and is charged to its flow. Returns false if
    /// it was not granted.
    bool take();

   private:
    friend IoTurns;
    Place(IoTurns& turns, std::uint64_t id, std::shared_ptr<Waiting> waiting)
        : turns_(&turns), id_(id), waiting_(std::move(waiting)) {}
    IoTurns* turns_;
    std::uint64_t id_;
    std::shared_ptr<Waiting> waiting_;  ///< null: moved or taken
  };

  // -- on an I/O thread

  /// Returns whether this flow's request may be handled at once. Also true if this thread already handles one
  /// in its current turn. The time of the turn is charged to the flow of the last call.
  bool begin(const Flow& flow);
  /// Call after begin() has returned false. `wake` is called when the turn is granted: on any I/O thread, and
  /// possibly before this function returns.
  Place wait(const Flow& flow, Call wake);
  /// Ends the thread's current turn, which took this processor time.
  void end_turn(double seconds);

  // -- on any thread

  /// Places that are destroyed from now on no longer call `later`.
  void stop();
  /// Number of requests that wait.
  std::size_t waiting() const;

 private:
  /// Frees a thread after all that is ready.
  void free_later() noexcept;
  /// `since`: value of ended_ when the turn was taken.
  void free_one(std::uint64_t since);
  /// Grants turns while a thread is free.
  void grant();

  const std::size_t threads_;
  const std::function<void(Call)> later_;
  std::atomic<std::uint64_t> ended_{0};  ///< turns of the threads, of any kind
  mutable std::mutex mutex_;
  std::size_t most_ = threads_;  ///< turns that may be granted at the same time
  FairQueue<Item> queue_;
  std::size_t waiting_ = 0;  ///< size of queue_
  std::uint64_t next_ = 0;
  std::size_t taken_ = 0;  ///< turns that were granted or taken, until their thread is free again
  bool stopped_ = false;
};

}  // namespace fracture::http
