// The open connections: which client owns each one, who may open another, and a handle on every session for
// the drain.
//
// Each connection takes a place, which belongs to a client: an address, or the client that a trusted proxy
// names. The number of places per client is limited. When all places are taken, the client with the most
// places gives one up to a newcomer. So a newcomer finds a place even if many clients hold a few places each.
//
// Refused connections take no place. A few at a time, and even fewer per client, stay open for a short time
// to receive the reason; the others are closed at once.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace fracture::http {

/// Actions of the drain and of a full listener on a session. Callable from any thread.
class Drainable {
 public:
  using Clock = std::chrono::steady_clock;
  virtual ~Drainable() = default;
  virtual void close_when_idle() = 0;
  virtual void cancel_job() = 0;
  /// The tokens have changed: the session checks whether it may continue its delivery.
  virtual void tokens_changed() = 0;

  enum class Leave {
    kIfItWaits,  ///< only if it is still waiting for its client; otherwise it answers first
    kAnyhow,     ///< even if it is computing: the work is abandoned
  };
  /// The session has lost its place and must close.
  virtual void give_way(Leave how) = 0;

  /// Returns the time since which the session has only been waiting for its client: for a request, for the
  /// rest of one, for the client to read an answer, or for the connection to end. Returns nothing while the
  /// session computes an answer.
  std::optional<Clock::time_point> waiting_since() const {
    const Clock::rep since = waiting_since_;
    return since == 0 ? std::nullopt : std::optional(Clock::time_point(Clock::duration(since)));
  }

 protected:
  void set_waiting(bool waiting) { waiting_since_ = waiting ? Clock::now().time_since_epoch().count() : 0; }

 private:
  std::atomic<Clock::rep> waiting_since_{Clock::now().time_since_epoch().count()};
};

/// Thread-safe. Must outlive its places.
class Connections {
 public:
  /// `most`: number of places. `most_of_client`: number of places for one client.
  Connections(std::size_t most, std::size_t most_of_client) : most_(most), most_of_client_(most_of_client) {}

  /// Maximum number of connections without a place that are kept open to receive a refusal: in total, and per
  /// client.
  static constexpr std::size_t kMostTold = 32, kMostToldOfClient = 4;
  /// Clients with up to this many places count as equal. Enough for a page and a game, for example.
  static constexpr std::size_t kFew = 8;
  /// Maximum number of connections that have lost their place but are not closed yet.
  static constexpr std::size_t kMostLeaving = 16;
  /// Maximum number of open connections in addition to the places.
  static constexpr std::size_t kMostBeyond = kMostTold + kMostLeaving;

  enum class Verdict { kWelcome, kTooManyOfClient, kFull };
  enum class OfClient {
    kLimited,
    kUnlimited,  ///< a proxy, which stands for many clients
  };

 private:
  /// Counts of one client: its places, connections that receive a refusal, and all open connections.
  struct Held {
    std::size_t places = 0, told = 0, open = 0;
  };
  using Clients = std::map<std::string, Held>;
  enum class Kind { kPlace, kTold, kLeaving };
  struct Entry {
    Kind kind;
    Clients::iterator client;
    const Drainable* session = nullptr;  ///< null until enroll()
    std::weak_ptr<Drainable> alive{};
  };
  using Entries = std::list<Entry>;  // oldest first

 public:
  /// A counted connection, from its accept to the end of its session.
  class Place {
   public:
    Place() = default;
    Place(Place&& other) noexcept : all_(std::exchange(other.all_, nullptr)), at_(other.at_) {}
    Place& operator=(Place&& other) noexcept {
      std::swap(all_, other.all_);
      std::swap(at_, other.at_);
      return *this;
    }
    ~Place() {
      if (all_) all_->remove(at_);
    }
    explicit operator bool() const { return all_ != nullptr; }

    /// Sets the session that owns this place. The place is a member of the session.
    void enroll(const std::shared_ptr<Drainable>& session) { all_->enroll(at_, session); }
    /// Transfers the place to this client. Returns false and changes nothing if the client has reached its
    /// limit.
    bool belongs_to(const std::string& client, OfClient limit) { return all_->move(at_, client, limit); }

   private:
    friend Connections;
    Place(Connections& all, Entries::iterator at) : all_(&all), at_(at) {}
    Connections* all_ = nullptr;
    Entries::iterator at_{};
  };

  struct Arrival {
    Verdict verdict;
    Place place{};  ///< empty: close the connection at once
  };
  Arrival add(const std::string& client, OfClient limit = OfClient::kLimited);

  /// Number of all open connections, including refused ones.
  std::size_t count() const {
    const std::lock_guard lock(mutex_);
    return entries_.size();
  }
  std::vector<std::shared_ptr<Drainable>> sessions() const;

  std::atomic<bool> stopping{false};  ///< draining: connections close after their answer
  std::atomic<std::size_t> in_progress{
      0};  ///< sessions between the first byte of a request and the last of its answer

 private:
  void enroll(Entries::iterator at, const std::shared_ptr<Drainable>& session);
  bool move(Entries::iterator at, const std::string& client, OfClient limit);
  void remove(Entries::iterator at);
  // The following functions need the lock.
  /// Makes room for a client. Returns the session that lost its place, or null if there is none.
  std::shared_ptr<Drainable> make_room_for(Clients::iterator client, OfClient limit);
  void count(const Entry& entry, bool open);
  void forget_if_gone(Clients::iterator client);

  const std::size_t most_, most_of_client_;
  mutable std::mutex mutex_;
  Clients clients_;  // only clients with open connections
  std::size_t places_ = 0, told_ = 0, leaving_ = 0;
  Entries entries_;
};

}  // namespace fracture::http
