// A single import: its memory, its tries, and how each of them ended.
#include "server/import_worker/import_pool.hpp"

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "common/base/words.hpp"
#include "common/import/picture_heads.hpp"

namespace fracture {

using std::chrono::milliseconds;

namespace {

/// Memory that a reader takes for each byte of the file, including arrays of doubles and the answer (measured over the test
/// meshes: 3 to 9 bytes). kMore: factor for the next try if a try had too little.
constexpr std::uint64_t kLeastMemory = 8u << 20, kMemoryPerByte = 10, kMore = 4;
/// Memory for each pixel of the largest picture. Pictures are decoded one at a time (surface_color/pixels.cpp).
constexpr std::uint64_t kMemoryPerPixel = 17, kMostPixels = 1u << 24;
/// Factor on a worker's memory for the reservation. The answer stays in shared memory after the worker has freed its own
/// memory, and then the server decodes it.
constexpr std::uint64_t kReserved = 2;
/// Shorter tries are not remembered, because repeating them costs little.
constexpr milliseconds kWorthRemembering{50};

std::uint64_t expected_memory(std::span<const std::byte> mesh, std::span<const ImportFile> files,
                              const Execution& execution) {
  std::uint64_t pixels = largest_picture(mesh, execution);
  for (const ImportFile& file : files) pixels = std::max(pixels, largest_picture(file.bytes, execution));
  return kLeastMemory + kMemoryPerByte * input_bytes(mesh, files) +
         kMemoryPerPixel * std::min(pixels, kMostPixels);
}

bool lacked_memory(const Expected<Mesh>& result) {
  return !result && result.error().code == ErrorCode::kImporterLimit &&
         result.error().extra->value("limit", "") == "memory";
}

/// Converts a memory limit to the memo's form. 0 means no limit.
std::uint64_t most_of(std::uint64_t memory_bytes) {
  return memory_bytes > 0 ? memory_bytes : ImportMemo::kAnyMemory;
}

/// Returns whether a try would be useless. An input that did not finish within some time is tried again only with at least
/// an eighth more time, because two tries with the same limit never run for exactly the same time.
bool refuses(const ImportMemo::Known& known, std::uint64_t memory_bytes, const Execution& execution) {
  if (known.error && most_of(memory_bytes) <= known.with_bytes) return true;
  if (known.needs_more_than.count() == 0 || !execution.deadline) return false;
  return *execution.deadline - ImportMemo::Clock::now() < known.needs_more_than / 8 * 9;
}

}  // namespace

Expected<Mesh> ImportPool::import(std::span<const std::byte> mesh, MeshFormat format,
                                  std::span<const ImportFile> files, const ImportLimits& limits,
                                  const Execution& execution, std::string_view digest,
                                  const StandsBack& stands_back, const Flow& flow) {
  execution.poll();
  std::uint64_t most = config_.worker.memory_bytes;
  if (execution.allowance) {
    const std::uint64_t share = execution.allowance->limit() / kReserved;
    most = most > 0 ? std::min(most, share) : share;
  }
  Input input{mesh, format, files, std::string(digest), {}, stands_back, flow};
  input.name = input.digest + "." + extension_of(format);
  if (const auto known = memo_.find(input.name); known && refuses(*known, most, execution)) {
    const std::lock_guard lock(mutex_);
    ++counters_.remembered;
    if (known->error && most_of(most) <= known->with_bytes) return tl::unexpected<Error>(*known->error);
    throw Interrupted{ErrorCode::kDeadlineExceeded};
  }
  Try attempt;
  // The estimate is high, so the first try leaves a quarter to others. If the file needs more, the next try gets everything.
  attempt.memory_bytes = std::min(most - most / 4, expected_memory(mesh, files, execution));
  for (;;) {
    const Allowance::Temporary held(execution.allowance);
    execution.made(Product::kImportBytes, kReserved * attempt.memory_bytes);
    attempt.last = attempt.memory_bytes >= most;
    if (std::optional<Expected<Mesh>> result = import_within(attempt, input, limits, execution))
      return std::move(*result);
    if (!attempt.was_killed) attempt.memory_bytes = std::min(most, kMore * attempt.memory_bytes);
    attempt.was_killed_before = attempt.was_killed_before || attempt.was_killed;
  }
}

std::optional<Expected<Mesh>> ImportPool::import_within(Try& attempt, const Input& input,
                                                        const ImportLimits& limits,
                                                        const Execution& execution) {
  execution.poll();
  Place place(*this, execution, input);
  Execution reading = execution;
  reading.turn = &place;
  std::unique_ptr<WorkerProcess> taken = take(place);
  WorkerProcess& worker = *taken;
  const pid_t pid = worker.pid();
  const auto start = ImportMemo::Clock::now();
  bool reusable = false;
  const auto finish = [&](std::uint64_t ImportCounters::*ended) {
    place.tell_of_use();
    {
      const std::lock_guard lock(mutex_);
      end(place);
      forget_clients();
      if (ended) ++(counters_.*ended);
      std::erase(busy_, pid);
    }
    reusable ? keep(std::move(taken)) : bury(std::move(taken));
  };
  try {
    Expected<Mesh> result = worker.import(input.mesh, input.format, input.files, input.digest, limits,
                                          reading, attempt.memory_bytes);
    const WorkerDeath death = worker.death();
    reusable =
        death == WorkerDeath::kNone && !lacked_memory(result) && worker.files() < config_.files_per_worker;
    // If the process has read other files before, they may be the cause of a crash or of a lack of memory. The file is then
    // tried again in another process.
    const bool had_less = lacked_memory(result) && worker.had_less();
    attempt.was_killed = death == WorkerDeath::kKilled || death == WorkerDeath::kNoRoom ||
                         ((death == WorkerDeath::kCrash || had_less) && worker.files() > 1);
    if ((lacked_memory(result) && !attempt.last) || (attempt.was_killed && !attempt.was_killed_before)) {
      finish(nullptr);
      return std::nullopt;
    }
    if (had_less)
      result = tl::unexpected<Error>(no_room_to_read(
          "this machine allows the process less memory than a single import may use (ulimit -v)"));
    const bool over_limit = !result && result.error().code == ErrorCode::kImporterLimit;
    const bool no_room = !result && result.error().code == ErrorCode::kOverloaded;
    if (lacked_memory(result) && attempt.memory_bytes > 0)
      result.error().detail = "The importer needed more than " + data_size(attempt.memory_bytes) +
                              " of memory for this file. " + config_.memory_advice;
    if (lacked_memory(result))
      memo_.add(input.name, result.error(), most_of(attempt.memory_bytes));
    else if (over_limit || death == WorkerDeath::kCrash)
      memo_.add(input.name, result.error());
    if (result)
      finish(&ImportCounters::imported);
    else if (no_room)
      finish(&ImportCounters::no_room);
    else if (over_limit)
      finish(&ImportCounters::limited);
    else
      finish(death == WorkerDeath::kNone ? &ImportCounters::refused : &ImportCounters::crashed);
    return result;
  } catch (const Interrupted& interrupted) {
    // Only processor time counts. If other processes had the processor, the import might have finished in the same time.
    const auto given = ImportMemo::Clock::now() - start, used = worker.processor_time();
    finish(&ImportCounters::interrupted);  // first, because the memo may run out of memory
    if (interrupted.code == ErrorCode::kDeadlineExceeded && used >= kWorthRemembering)
      memo_.add(input.name, used >= given / 4 * 3 ? given : used);
    throw;
  } catch (const std::system_error& e) {  // no descriptor or no shared memory
    finish(&ImportCounters::no_room);
    return tl::unexpected<Error>(no_room_to_read(e.what()));
  } catch (...) {  // the server is out of memory, and the state of the worker is not known
    finish(&ImportCounters::no_room);
    throw;
  }
}

}  // namespace fracture
