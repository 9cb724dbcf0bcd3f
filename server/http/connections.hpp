// The open connections: whose each is, who may have a further one, and a handle on every session for the drain.
//
// A connection has a place, which belongs to a client: an address, or the client for whom a trusted proxy says that it
// asks. Each client has so many at most. When all places are taken, the client that has most makes room for a newcomer. So
// that one finds a place, however many clients hold a little.
//
// A connection that is refused takes none of these places. A few at a time are told why, of one client fewer still, and
// not for long; the others are closed at once.
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

/// What the drain and a full listener do to a session, from any thread.
class Drainable {
 public:
  using Clock = std::chrono::steady_clock;
  virtual ~Drainable() = default;
  virtual void close_when_idle() = 0;
  virtual void cancel_job() = 0;
  /// Other tokens are in force: it may have to stop what it delivers.
  virtual void tokens_changed() = 0;

  enum class Leave {
    kIfItWaits,  ///< where it waits for its client no longer, it answers first
    kAnyhow,     ///< what it computes is given up
  };
  /// It has lost its place, and closes.
  virtual void give_way(Leave how) = 0;

  /// Since when it has only waited for its client: for a request, for the rest of one, for its taking an answer,
  /// for the end of the connection. Nothing while it computes one.
  std::optional<Clock::time_point> waiting_since() const {
    const Clock::rep since = waiting_since_;
    return since == 0 ? std::nullopt : std::optional(Clock::time_point(Clock::duration(since)));
  }

 protected:
  void set_waiting(bool waiting) { waiting_since_ = waiting ? Clock::now().time_since_epoch().count() : 0; }

 private:
  std::atomic<Clock::rep> waiting_since_{Clock::now().time_since_epoch().count()};
};

/// Thread-safe. Outlives its places.
class Connections {
 public:
  /// `most` places, of them `most_of_client` for one client.
  Connections(std::size_t most, std::size_t most_of_client) : most_(most), most_of_client_(most_of_client) {}

  /// Connections beyond the places that are open at the same time to be told why they are refused; of one client.
  static constexpr std::size_t kMostTold = 32, kMostToldOfClient = 4;
  /// Places of a client that are no more than anybody's: a page and a game, say.
  static constexpr std::size_t kFew = 8;
  /// Connections that have lost their place and are not closed yet.
  static constexpr std::size_t kMostLeaving = 16;
  /// All that may be open beyond the places.
  static constexpr std::size_t kMostBeyond = kMostTold + kMostLeaving;

  enum class Verdict { kWelcome, kTooManyOfClient, kFull };
  enum class OfClient {
    kLimited,
    kUnlimited,  ///< it is a proxy, and so many clients
  };

 private:
  /// One client's places, connections that are being told why they have none, and all that are open.
  struct Held {
    std::size_t places = 0, told = 0, open = 0;
  };
  using Clients = std::map<std::string, Held>;
  enum class Kind { kPlace, kTold, kLeaving };
  struct Entry {
    Kind kind;
    Clients::iterator client;
    const Drainable* session = nullptr;  ///< null before enroll()
    std::weak_ptr<Drainable> alive{};
  };
  using Entries = std::list<Entry>;  // oldest first

 public:
  /// A connection that is counted, from its accept to the end of its session.
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

    /// The session that has it. The place is a member of the session.
    void enroll(const std::shared_ptr<Drainable>& session) { all_->enroll(at_, session); }
    /// It is this client's from now on. False, and nothing changes, where that client has as many as it may.
    bool belongs_to(const std::string& client, OfClient limit) { return all_->move(at_, client, limit); }

   private:
    friend Connections;
    Place(Connections& all, Entries::iterator at) : all_(&all), at_(at) {}
    Connections* all_ = nullptr;
    Entries::iterator at_{};
  };

  struct Arrival {
    Verdict verdict;
    Place place{};  ///< none: it is to be closed at once
  };
  Arrival add(const std::string& client, OfClient limit = OfClient::kLimited);

  /// All that are open, refused ones too.
  std::size_t count() const {
    const std::lock_guard lock(mutex_);
    return entries_.size();
  }
  std::vector<std::shared_ptr<Drainable>> sessions() const;

  std::atomic<bool> stopping{false};  ///< the drain has begun: no connection is kept after its answer
  std::atomic<std::size_t> in_progress{
      0};  ///< sessions between the first byte of a request and the last of its answer

 private:
  void enroll(Entries::iterator at, const std::shared_ptr<Drainable>& session);
  bool move(Entries::iterator at, const std::string& client, OfClient limit);
  void remove(Entries::iterator at);
  // With the lock.
  /// Somebody loses a place to a client: the session, to be told so. Null: nobody does.
  std::shared_ptr<Drainable> make_room_for(Clients::iterator client, OfClient limit);
  void count(const Entry& entry, bool open);
  void forget_if_gone(Clients::iterator client);

  const std::size_t most_, most_of_client_;
  mutable std::mutex mutex_;
  Clients clients_;  // none without connections
  std::size_t places_ = 0, told_ = 0, leaving_ = 0;
  Entries entries_;
};

}  // namespace fracture::http
