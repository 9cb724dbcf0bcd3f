#include "server/bake/patient_caller.hpp"

#include <algorithm>
#include <utility>

#include "common/exchange/backoff.hpp"
#include "common/exchange/headers.hpp"

namespace fracture::bake {
namespace {

using Milliseconds = std::chrono::milliseconds;
using protocol::Exchange;

/// A busy server is only reported after this time.
constexpr Milliseconds kBusyUnsaid{5'000};

bool is_busy(const Exchange& exchange) {
  switch (exchange.status) {
    case 408:
    case 429:
    case 502:
    case 503:
      return true;
    case 504:
      return problem_of(exchange).slug().empty();
    default:
      return false;
  }
}

std::string seconds_text(Milliseconds time) { return std::to_string((time.count() + 999) / 1000) + " s"; }

}  // namespace

protocol::ProblemDocument problem_of(const Exchange& exchange) {
  if (exchange.content_type.starts_with("application/problem+json")) return protocol::problem_in(exchange);
  return {.detail = "The server answered " + std::to_string(exchange.status) + "."};
}

PatientCaller::PatientCaller(const protocol::ConnectionSettings& settings, const Patience& patience)
    : server_(settings.authority()), patience_(patience), caller_(settings) {}

Expected<Exchange> PatientCaller::ask(const protocol::HttpRequest& request, const std::stop_token& stop) {
  const Clock::time_point begun = Clock::now();
  protocol::Backoff backoff(patience_.first_pause, patience_.longest_pause);
  for (;;) {
    {
      const std::lock_guard lock(mutex_);
      if (!gave_up_.empty()) return fail(ErrorCode::kUnavailable, gave_up_);
    }
    Exchange exchange = caller_.exchange(request, stop);
    if (stop.stop_requested() || exchange.outcome == Exchange::Outcome::kInterrupted)
      return fail(ErrorCode::kCancelled, "Stopped.");
    const bool answered = exchange.outcome == Exchange::Outcome::kAnswered;
    const bool busy = answered && is_busy(exchange);
    if (answered && (exchange.status == 401 || exchange.status == 403))
      return tl::unexpected(give_up(server_ + " refuses the token (" + std::to_string(exchange.status) +
                                    "): " + problem_of(exchange).detail +
                                    " Give --token or set FRACTURE_TOKEN."));
    if (answered && !busy) {
      heard();
      return exchange;
    }
    if (exchange.outcome == Exchange::Outcome::kTooLarge) return fail(ErrorCode::kTooLarge, exchange.detail);
    // A job's event stream may outlast the time limit of one request: reconnect.
    if (exchange.outcome == Exchange::Outcome::kTimedOut && exchange.began) {
      heard();
      continue;
    }
    const std::string trouble =
        busy ? server_ + " is busy (" + std::to_string(exchange.status) + "): " + problem_of(exchange).detail
             : exchange.detail;
    const Milliseconds left = hope(begun, busy, trouble);
    if (left.count() <= 0)
      return tl::unexpected(give_up(trouble + " The server gave no other response within " +
                                    seconds_text(patience_.total) + " (--patience)."));
    const Milliseconds wait = std::max(
        backoff.pause(), protocol::parse_retry_after(exchange.retry_after).value_or(backoff.pause()));
    backoff.lengthen();
    pause(std::min(wait, left), stop);
  }
}

void PatientCaller::pause(Milliseconds time, const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, stop, time, [this] { return !gave_up_.empty(); });
}

Error PatientCaller::give_up(const std::string& detail) {
  const std::lock_guard lock(mutex_);
  if (gave_up_.empty()) gave_up_ = detail;
  changed_.notify_all();
  return {ErrorCode::kUnavailable, gave_up_};
}

void PatientCaller::heard() {
  bool again = false;
  {
    const std::lock_guard lock(mutex_);
    heard_ = Clock::now();
    again = std::exchange(trouble_said_, false);
  }
  if (again) say_(server_ + " responds again.");
}

Milliseconds PatientCaller::hope(Clock::time_point begun, bool busy, const std::string& trouble) {
  Milliseconds silent, left;
  bool say = false;
  {
    const std::lock_guard lock(mutex_);
    silent = std::chrono::duration_cast<Milliseconds>(Clock::now() - std::max(begun, heard_));
    left = patience_.total - silent;
    say = !trouble_said_ && left.count() > 0 && (!busy || silent >= kBusyUnsaid);
    if (say) trouble_said_ = true;
  }
  if (say) say_(trouble + " Trying again for " + seconds_text(left) + ".");
  return left;
}

}  // namespace fracture::bake
