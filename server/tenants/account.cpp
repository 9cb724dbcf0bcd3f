#include "server/tenants/account.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace fracture::tenants {
namespace {

/// Seconds. Processor time that was not used within this window may be used at once.
constexpr double kProcessorWindow = 10;

/// burst_of(): how many requests may come at once. window_of(): after how many seconds the same number may come again.
double burst_of(double rate) { return std::max(1.0, std::floor(rate)); }
double window_of(double rate) { return std::max(1.0, std::ceil(burst_of(rate) / rate)); }

std::string whole(double value) { return std::to_string(std::llround(value)); }

std::string plain(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

std::chrono::seconds whole_seconds(std::chrono::duration<double> wait) {
  return std::chrono::seconds(static_cast<long>(std::clamp(std::ceil(wait.count()), 1.0, 86400.0)));
}

}  // namespace

Account::Account(Tenant tenant, bool isolated)
    : name_(std::move(tenant.name)), scopes_(tenant.scopes), shares_(tenant.shares), isolated_(isolated) {}

void Account::configure(Tenant tenant, bool isolated) {
  const std::lock_guard lock(mutex_);
  scopes_ = tenant.scopes;
  shares_ = tenant.shares;
  isolated_ = isolated;
}

Scopes Account::scopes() const {
  const std::lock_guard lock(mutex_);
  return scopes_;
}

Shares Account::shares() const {
  const std::lock_guard lock(mutex_);
  return shares_;
}

std::string Account::owner() const {
  const std::lock_guard lock(mutex_);
  return isolated_ ? name_ : "";
}

bool Account::sees(const std::string& owner) const {
  const std::lock_guard lock(mutex_);
  return !isolated_ || owner == name_ || scopes_.has(Scope::kAdmin);
}

void Account::advance(Clock::time_point now) {
  if (const auto rate = shares_.requests_per_second) requests_.advance(*rate, burst_of(*rate), now);
  if (const auto rate = shares_.cores) processor_.advance(*rate, *rate * kProcessorWindow, now);
}

Error Account::over(std::string what, std::chrono::duration<double> wait) {
  ++figures_.over_share;
  return {.code = ErrorCode::kOverShare,
          .detail = "'" + name_ + "' is over its share: " + std::move(what),
          .retry_after = whole_seconds(wait)};
}

std::optional<Error> Account::request(Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  ++figures_.requests;
  advance(now);
  const auto rate = shares_.requests_per_second;
  if (!rate) return std::nullopt;
  if (requests_.level() < 1)
    return over("its limit is " + plain(*rate) + " requests a second.", requests_.until(1, *rate));
  requests_.take(1);
  return std::nullopt;
}

std::vector<std::pair<std::string, std::string>> Account::rate_fields(Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  advance(now);
  std::string policy, left;
  const auto add = [&](const char* name, double quota, double window, double level, double rate) {
    const std::string item = (policy.empty() ? "\"" : ", \"") + std::string(name) + "\";";
    policy += item + "q=" + whole(quota) + ";w=" + whole(window);
    left += item + "r=" + whole(std::max(0.0, std::floor(level))) +
            ";t=" + whole(std::ceil(std::max(0.0, quota - level) / rate));
  };
  if (const auto rate = shares_.requests_per_second)
    add("requests", burst_of(*rate), window_of(*rate), requests_.level(), *rate);
  if (const auto rate = shares_.cores)  // in milliseconds, because the fields contain whole numbers
    add("processor-ms", std::ceil(1000 * *rate * kProcessorWindow), kProcessorWindow,
        1000 * processor_.level(), 1000 * *rate);
  if (policy.empty()) return {};
  return {{"RateLimit-Policy", policy}, {"RateLimit", left}};
}

Expected<Account::Seat> Account::begin_computation(Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  advance(now);
  if (const auto rate = shares_.cores; rate && processor_.level() <= 0)
    return tl::unexpected<Error>(over("its limit is " + plain(*rate) + " processor seconds per second.",
                                      processor_.until(0.1 * *rate, *rate)));
  if (computations_ >= shares_.computations)
    return tl::unexpected<Error>(
        over("its limit is " + std::to_string(shares_.computations) + " computations at the same time.",
             std::chrono::seconds(1)));
  ++computations_;
  return Seat(shared_from_this());
}

bool Account::is_over_processor_rate(Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  advance(now);
  return shares_.cores && processor_.level() <= 0;
}

std::chrono::duration<double> Account::until_within_processor_rate(Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  advance(now);
  return shares_.cores ? processor_.until(0, *shares_.cores) : std::chrono::duration<double>(0);
}

void Account::charge(double processor_seconds, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  advance(now);
  if (shares_.cores) processor_.take(processor_seconds);
  figures_.processor_seconds += processor_seconds;
}

void Account::count_answer(std::uint64_t bytes_in, std::uint64_t bytes_out) {
  const std::lock_guard lock(mutex_);
  figures_.bytes_in += bytes_in;
  figures_.bytes_out += bytes_out;
}

Account::Figures Account::figures() const {
  const std::lock_guard lock(mutex_);
  Figures figures = figures_;
  figures.computations = computations_;
  return figures;
}

}  // namespace fracture::tenants
