#include "server/cli/memory_plan.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <type_traits>

namespace fracture::cli {
namespace {

constexpr std::uint64_t kMiB = 1u << 20;

/// A memory budget that is a setting. `least`: the minimum with which a server is useful.
struct Budget {
  const char* setting;
  const char* part;
  std::uint64_t least;
  std::function<std::uint64_t(const ServeOptions&)> get;
  std::function<void(ServeOptions&, std::uint64_t)> set;
};

/// Creates a budget. `where(options)` returns a reference to its number.
template <class Where>
Budget budget(const char* setting, const char* part, std::uint64_t least, Where where) {
  return {setting, part, least, [where](const ServeOptions& o) { return std::uint64_t{where(o)}; },
          [where](ServeOptions& o, std::uint64_t bytes) {
            auto& number = where(o);
            number = static_cast<std::remove_reference_t<decltype(number)>>(bytes);
          }};
}

std::vector<Budget> budgets(const ServeOptions& given_options, const std::set<std::string>& given = {}) {
  const std::uint64_t body = given.contains("max-body") ? given_options.limits.max_body : 0,
                      import = given.contains("import-memory") ? given_options.import_memory : 0;
  return {
      {"max-connections", "connections",
       given_options.limits.max_connections_per_address * http::kConnectionBytes,
       [](const ServeOptions& o) { return o.limits.max_connections * http::kConnectionBytes; },
       [](ServeOptions& o, std::uint64_t bytes) {
         o.limits.max_connections = static_cast<std::size_t>(bytes / http::kConnectionBytes);
       }},
      budget(
          "max-bodies", "bodies", std::max(4 * kMiB, body),
          [](auto& o) -> auto& { return o.limits.max_bodies; }),
      budget(
          "max-small-bodies", "small_bodies", kMiB,
          [](auto& o) -> auto& { return o.limits.max_small_bodies; }),
      budget(
          "max-answers", "answers", kMiB, [](auto& o) -> auto& { return o.limits.max_answers; }),
      budget(
          "max-working", "working", std::max(64 * kMiB, import),
          [](auto& o) -> auto& { return o.dispatcher.max_working_bytes; }),
      budget(
          "mesh-cache", "mesh_cache", 0, [](auto& o) -> auto& { return o.service.mesh_cache_bytes; }),
      budget(
          "diagram-cache", "diagram_cache", 0,
          [](auto& o) -> auto& { return o.service.diagram_cache_bytes; }),
      budget(
          "result-cache", "result_cache", 0, [](auto& o) -> auto& { return o.service.result_cache_bytes; }),
      budget(
          "mesh-store", "mesh_store", 0, [](auto& o) -> auto& { return o.store.quota_bytes; }),
      budget(
          "job-results", "job_results", 0, [](auto& o) -> auto& { return o.jobs.max_result_bytes; }),
      budget(
          "answer-ledger", "answer_ledger", 0, [](auto& o) -> auto& { return o.limits.answer_ledger; })};
}

std::uint64_t threads_of(const ServeOptions& o) {
  return static_cast<std::uint64_t>((o.threads > 0 ? o.threads : available_cores()) + o.server.io_threads);
}

std::string in_mib(double bytes) { return std::to_string(static_cast<std::uint64_t>(bytes / kMiB)) + " MiB"; }

bool any_tier(const ServeOptions& o) {
  const TiersConfig& tiers = o.service.tiers;
  return !tiers.folder.empty() || !tiers.redis.address.empty();
}

/// Answers waiting to be stored in a tier may take at most 1/kPendingPart of the memory.
constexpr std::uint64_t kPendingPart = 32;

/// Returns the smallest working value for --memory in MiB. `needed` excludes answers waiting to be stored in
/// a tier. If there is a tier, these get 1/kPendingPart of the memory, but at most `pending`.
std::uint64_t least_memory(double needed, std::size_t pending, bool tier) {
  const double parts = kPendingPart, with_part = needed * parts / (parts - 1),
               bytes = tier ? std::min(needed + static_cast<double>(pending), with_part) : needed;
  return static_cast<std::uint64_t>(std::ceil(bytes / kMiB));
}

}  // namespace

std::vector<MemoryShare> memory_shares(const ServeOptions& options) {
  std::vector<MemoryShare> shares;
  for (const Budget& b : budgets(options)) shares.push_back({b.setting, b.part, b.get(options)});
  return shares;
}

std::uint64_t base_memory(const ServeOptions& o) {
  // The process takes 26 MiB after its start, each thread's allocator arena keeps some memory, and an idle
  // import worker takes 6 MiB. Two processes are added to the import workers: one worker for urgent requests,
  // and the zygote that forks them, which takes 15 MiB.
  const std::uint64_t importers = 2 + static_cast<std::uint64_t>(o.import_workers);
  return 32 * kMiB + 8 * kMiB * threads_of(o) + 16 * kMiB * importers +
         (any_tier(o) ? o.service.tiers.max_pending_bytes : 0);
}

std::vector<std::string> plan_memory(ServeOptions& o, const std::set<std::string>& given,
                                     std::uint64_t available) {
  const std::vector<Budget> all = budgets(o, given);
  const std::size_t pending = o.service.tiers.max_pending_bytes;  // answers waiting to be stored
  o.service.tiers.max_pending_bytes = std::min<std::size_t>(pending, available / kPendingPart);
  const double base = static_cast<double>(base_memory(o));
  const double room = (static_cast<double>(available) - base) / kResidentPerByte;
  double fixed = 0, elastic = 0, least = 0;
  for (const Budget& b : all) {
    const auto bytes = static_cast<double>(b.get(o));
    if (given.contains(b.setting)) {
      fixed += bytes;
    } else {
      elastic += bytes;
      least += static_cast<double>(std::min(b.least, b.get(o)));
    }
  }
  if (fixed + least > room) {
    const double needed = base + kResidentPerByte * (fixed + least),
                 on_their_way = any_tier(o) ? static_cast<double>(o.service.tiers.max_pending_bytes) : 0;
    o.service.tiers.max_pending_bytes = pending;
    std::string sum;
    for (const Budget& b : all) {
      const bool is_given = given.contains(b.setting);
      if (!is_given && b.least == 0) continue;
      sum += (sum.empty() ? "" : " + ") + std::string(b.setting) + " " +
             (is_given ? in_mib(static_cast<double>(b.get(o)))
                       : "at least " + in_mib(static_cast<double>(std::min(b.least, b.get(o)))));
    }
    return {
        "memory: " + in_mib(base) + " at rest + " + std::to_string(kResidentPerByte).substr(0, 3) + " x (" +
        sum + ") = " + in_mib(needed) + ", which is more than the " + in_mib(static_cast<double>(available)) +
        " that this server may use (--memory, its control group's limit, or the machine's memory); the smallest value that "
        "works is " +
        std::to_string(least_memory(needed - on_their_way, pending, any_tier(o))) + " MiB"};
  }
  if (fixed + elastic > room) {
    const double share = (room - fixed - least) / std::max(1.0, elastic - least);
    for (const Budget& b : all) {
      if (given.contains(b.setting)) continue;
      const auto bytes = static_cast<double>(b.get(o)),
                 low = static_cast<double>(std::min(b.least, b.get(o)));
      b.set(o, static_cast<std::uint64_t>(low + share * (bytes - low)));
    }
  }
  const auto at_most = [&](const char* setting, auto& value, std::uint64_t limit) {
    if (!given.contains(setting) && value > limit) value = limit;
  };
  at_most("max-body", o.limits.max_body, o.limits.max_bodies);
  at_most("max-decoded", o.service.import_limits.max_decoded_bytes, o.limits.max_bodies);
  at_most("import-memory", o.import_memory, o.dispatcher.max_working_bytes / 2);
  o.memory = available;
  return {};
}

}  // namespace fracture::cli
