#include "client/game/peer_link.hpp"

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <deque>
#include <iterator>
#include <mutex>
#include <thread>
#include <utility>

#include "common/exchange/asio.hpp"
#include "common/exchange/exchange.hpp"

namespace fracture::game {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kTick(100);  ///< between clock checks and connection attempts
constexpr std::chrono::seconds kLastWords(1);    ///< at the end, time for unsent lines
constexpr const char* kAlive = "{}";

std::string seconds_text(std::chrono::milliseconds time) {
  const auto tenths = time.count() / 100;
  return std::to_string(tenths / 10) + (tenths % 10 == 0 ? "" : "." + std::to_string(tenths % 10)) + " s";
}

}  // namespace

struct PeerLink::State {
  explicit State(PeerSettings s)
      : settings(s), acceptor(io), socket(io), resolver(io), timer(io), started(Clock::now()) {}

  void run() {
    tick();
    thread = std::thread([this] { io.run(); });
  }

  // -- from here on: IO thread

  void end(const std::string& why) {
    {
      const std::lock_guard lock(mutex);
      if (!ended) ended = why;
    }
    close();
  }
  void close() {
    over = true;
    error_code ignored;
    acceptor.close(ignored);
    socket.close(ignored);
    resolver.cancel();
    timer.cancel();
  }

  void accept() {
    accepting = true;
    acceptor.async_accept(socket, [this](const error_code& error) {
      accepting = false;
      if (over || error == asio::error::operation_aborted) return;
      if (error) {  // the next tick tries again
        trouble = error.message();
        return;
      }
      outbox = greeting;
      begin();
    });
  }
  /// The connection is lost. If it was not a player's, the inviting side keeps listening, because other
  /// programs also scan ports.
  void lose(const std::string& why) {
    if (known || stopping) return end(why);
    error_code ignored;
    socket.close(ignored);
    connected = reading = false;
    received.clear();
    accept();
  }
  void connect() {
    connecting = true;
    resolver.async_resolve(
        host, service, [this](const error_code& error, const tcp::resolver::results_type& found) {
          if (over) return;
          if (error) {
            trouble = error.message();
            connecting = false;
            return;
          }
          asio::async_connect(socket, found, [this](const error_code& failed, const tcp::endpoint&) {
            if (over) return;
            connecting = false;
            if (!failed) return begin();
            trouble = failed.message();
            error_code ignored;
            socket.close(ignored);
          });
        });
  }

  void begin() {
    connected = true;
    heard = sent = Clock::now();
    error_code ignored;
    socket.set_option(tcp::no_delay(true), ignored);
    read();
    write();
  }

  /// Everything is sent. If a socket is closed before it has read everything, data it sent may be lost (RFC
  /// 1122, 4.2.2.13). So the other side closes first, or kLastWords pass.
  void part() {
    error_code ignored;
    socket.shutdown(tcp::socket::shutdown_send, ignored);
    read_on();
  }

  void read() {
    reading = true;
    asio::async_read_until(socket, asio::dynamic_buffer(received, settings.most_line), '\n',
                           [this](const error_code& error, std::size_t size) {
                             if (!over) take(error, size);
                           });
  }
  void take(const error_code& error, std::size_t size) {
    reading = false;
    if (error == asio::error::operation_aborted) return;
    if (error == asio::error::not_found)
      return lose("The other player sent a line with more than " + std::to_string(settings.most_line) +
                  " bytes.");
    if (error) return lose("The other player has left the game.");
    heard = Clock::now();
    std::string line = received.substr(0, size - 1);
    received.erase(0, size);
    if (!known) {
      if (!line.starts_with('{')) return lose("");
      known = true;
      greeting.clear();
      error_code ignored;
      acceptor.close(ignored);  // only two players can take part
    }
    bool room = true;
    {
      const std::lock_guard lock(mutex);
      if (line != kAlive && !stopping) lines.push_back(std::move(line));
      room = stopping || lines.size() < settings.most_waiting;
    }
    if (room) read();
  }
  void read_on() {
    if (connected && !over && !reading) read();
  }

  void write() {
    if (!connected || over || writing || outbox.empty()) return;
    writing = true;
    sent = Clock::now();
    asio::async_write(socket, asio::buffer(outbox.front()), [this](const error_code& error, std::size_t) {
      writing = false;
      if (over || !connected) return;
      // After a failed write, lines that the other side sent before it left are still read.
      outbox.pop_front();
      if (error) outbox.clear();
      if (outbox.empty() && stopping) return part();
      write();
    });
  }

  void tick() {
    timer.expires_after(kTick);
    timer.async_wait([this](const error_code& error) {
      if (over || error) return;
      const Clock::time_point now = Clock::now();
      if (stopping && now > *stopping + kLastWords) return close();
      if ((!connected || !known) && now > started + settings.patience)
        return end((host.empty() ? "No player joined"
                                 : "No player answered at " + protocol::authority_of(host, service)) +
                   " within " + seconds_text(settings.patience) +
                   (trouble.empty() ? "" : " (" + trouble + ")") + ".");
      if (connected && !reading) heard = now;  // silence does not count while nothing is read
      if (connected && now > heard + (known ? settings.silence : settings.strange_silence))
        lose("The other player sent nothing for " + seconds_text(settings.silence) + ".");
      if (over) return;
      if (connected && !writing && now > sent + settings.beat) {
        outbox.push_back(std::string(kAlive) + '\n');
        write();
      }
      if (!connected && !host.empty() && !connecting) connect();
      if (!connected && host.empty() && !accepting && acceptor.is_open()) accept();
      tick();
    });
  }

  const PeerSettings settings;
  asio::io_context io{1};
  tcp::acceptor acceptor;
  tcp::socket socket;
  tcp::resolver resolver;
  asio::steady_timer timer;
  std::uint16_t port = 0;     ///< of the inviting side
  std::string host, service;  ///< of the side to join; empty on the inviting side
  std::string received, trouble;
  std::deque<std::string> outbox;
  std::deque<std::string> greeting;  ///< sent to every connection until the player is known
  bool known = false;                ///< the other side is a player: it has sent a JSON object, or was joined
  bool accepting = false, connected = false, connecting = false, reading = false, writing = false,
       over = false;
  std::optional<Clock::time_point> stopping;
  Clock::time_point started, heard, sent;

  mutable std::mutex mutex;  ///< protects the following members
  std::vector<std::string> lines;
  std::optional<std::string> ended;

  std::thread thread;
};

PeerLink::PeerLink(std::unique_ptr<State> state) : state_(std::move(state)) { state_->run(); }

Expected<std::unique_ptr<PeerLink>> PeerLink::invite(const std::string& address, std::uint16_t port,
                                                     PeerSettings settings) {
  auto state = std::make_unique<State>(settings);
  error_code error;
  const auto local = asio::ip::make_address(address, error);
  const tcp::endpoint endpoint(local, port);
  if (!error) state->acceptor.open(endpoint.protocol(), error);
  if (!error) state->acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) state->acceptor.bind(endpoint, error);
  if (!error) state->acceptor.listen(1, error);
  if (!error) state->port = state->acceptor.local_endpoint(error).port();
  if (error)
    return fail(ErrorCode::kUnavailable, "Cannot listen for a player at " + address + ":" +
                                             std::to_string(port) + ": " + error.message() + ".");
  state->accept();
  return std::unique_ptr<PeerLink>(new PeerLink(std::move(state)));
}

std::unique_ptr<PeerLink> PeerLink::join(std::string host, std::uint16_t port, PeerSettings settings) {
  auto state = std::make_unique<State>(settings);
  state->host = std::move(host);
  state->service = std::to_string(port);
  state->known = true;
  state->connect();
  return std::unique_ptr<PeerLink>(new PeerLink(std::move(state)));
}

PeerLink::~PeerLink() {
  asio::post(state_->io, [state = state_.get()] {
    state->stopping = Clock::now();
    if (!state->connected) return state->close();
    if (state->outbox.empty()) state->part();
  });
  state_->thread.join();
}

void PeerLink::send(std::string line) {
  asio::post(state_->io, [state = state_.get(), line = std::move(line)]() mutable {
    line += '\n';
    if (!state->known) state->greeting.push_back(line);
    if (state->known || state->connected) state->outbox.push_back(std::move(line));
    state->write();
  });
}

std::vector<std::string> PeerLink::poll(std::size_t most) {
  std::vector<std::string> lines;
  bool has_room_again = false;
  {
    const std::lock_guard lock(state_->mutex);
    const bool was_full = state_->lines.size() >= state_->settings.most_waiting;
    if (state_->lines.size() <= most) {
      lines.swap(state_->lines);
    } else {
      const auto end = state_->lines.begin() + static_cast<std::ptrdiff_t>(most);
      lines.assign(std::make_move_iterator(state_->lines.begin()), std::make_move_iterator(end));
      state_->lines.erase(state_->lines.begin(), end);
    }
    has_room_again = was_full && state_->lines.size() < state_->settings.most_waiting;
  }
  if (has_room_again) asio::post(state_->io, [state = state_.get()] { state->read_on(); });
  return lines;
}

std::optional<std::string> PeerLink::ended() const {
  const std::lock_guard lock(state_->mutex);
  return state_->lines.empty() ? state_->ended : std::nullopt;
}

std::uint16_t PeerLink::port() const { return state_->port; }

}  // namespace fracture::game
