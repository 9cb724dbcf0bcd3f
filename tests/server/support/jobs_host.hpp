// Jobs without an HTTP server, so that a test itself starts, resumes, sweeps and stops them.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <future>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "server/jobs/jobs.hpp"
#include "tests/server/support/fake_engine.hpp"
#include "tests/server/support/fracture_request.hpp"
#include "tests/server/support/job_server.hpp"

namespace fracture::test {

/// A deadline that no test reaches.
inline std::chrono::steady_clock::time_point far_off() {
  return std::chrono::steady_clock::now() + std::chrono::minutes(10);
}

/// With a folder, it has a disk tier in that folder and its jobs in the subfolder "jobs".
struct JobsHost {
  explicit JobsHost(const std::string& folder = "", std::shared_ptr<FakeControl> its_control = nullptr)
      : control(its_control ? std::move(its_control) : std::make_shared<FakeControl>()),
        service(service_config(folder), std::make_unique<FakeEngine>(control)),
        jobs(dispatcher, jobs_config(folder, [this] {
               if (before_mark) before_mark();
             })) {}
  ~JobsHost() {
    jobs.stop();
    idle();
  }

  /// Starts a different job for each `seed`. Returns its id once it is accepted.
  std::string start(std::uint64_t seed, Terms terms = {}, const std::string& owner = "") {
    terms.priority = Priority::kBackground;
    if (terms.deadline == std::chrono::steady_clock::time_point::max()) terms.deadline = far_off();
    const auto id = std::make_shared<std::promise<std::string>>();
    const auto refused = jobs.start(fracture_request("mesh", seed), terms, Jobs::Owner{owner},
                                    [id](const JobView& job) { id->set_value(job.id); });
    if (refused) throw std::runtime_error(refused->detail);
    std::future<std::string> accepted = id->get_future();
    if (accepted.wait_for(kPatience) != std::future_status::ready) throw std::runtime_error("not accepted");
    return accepted.get();
  }
  /// Resumes the jobs in the folder. No client is charged for them.
  void resume() {
    jobs.resume([](const std::string&) { return Terms{}; }, [](const JobView&) {});
  }
  JobView find(const std::string& id) {
    const std::optional<JobView> view = jobs.find(id);
    if (!view) throw std::runtime_error("no such job: " + id);
    return *view;
  }
  JobView wait_for(const std::string& id, JobState state) {
    JobView view;
    EXPECT_TRUE(eventually(kPatience, id + " to be " + name_of(state),
                           [&] {
                             view = find(id);
                             return view.state == state;
                           }))
        << "it is " << name_of(view.state);
    return view;
  }
  /// Waits until nothing is computed any more and all results are on the disk.
  void idle() {
    jobs.flush();
    dispatcher.wait_idle();
    jobs.flush();
  }

  static ServiceConfig service_config(const std::string& folder) {
    ServiceConfig config;
    config.tiers.folder = folder;
    return config;
  }
  static JobsConfig jobs_config(const std::string& folder, std::function<void()> before_mark) {
    JobsConfig config;
    if (!folder.empty()) config.folder = folder + "/jobs";
    config.before_mark = std::move(before_mark);
    return config;
  }

  std::function<void()> before_mark;  ///< called on the thread of a job, before its mark is written
  std::shared_ptr<FakeControl> control;
  FractureService service;
  WorkerPool pool{4, 64};
  Dispatcher dispatcher{service, pool};
  Jobs jobs;
};

/// Leaves a job in the folder of a JobsHost, as an earlier process would. Without a client, the record is one of
/// an earlier release. Returns its id.
inline std::string leave_job(const std::string& folder, std::uint64_t seed, const std::string& owner = "",
                             std::chrono::milliseconds patience = std::chrono::minutes(10),
                             const std::string& client = "") {
  const FractureRequest request = fracture_request("mesh", seed);
  const RequestKeys keys = keys_of(request);
  JobRecord record;
  char number[17];
  std::snprintf(number, sizeof number, "%016llx", static_cast<unsigned long long>(seed));
  record.id = keys.digest.substr(0, 16) + "-" + number;
  record.owner = owner;
  record.client = client;
  record.created += std::chrono::seconds(1'700'000'000 + seed);
  record.patience = patience;
  record.digest = keys.digest;
  record.mesh_bytes = request.mesh.size();
  record.parameters = canonical_parameters(request.parameters);
  record.result_key = keys.result;
  JobFolder jobs({folder + "/jobs"});
  if (!jobs.take().value_or(false) || jobs.reserve(record, UINT64_MAX) != JobFolder::Room::kThere ||
      !jobs.write(record, request))
    throw std::runtime_error("the folder did not take the job");
  return record.id;
}

/// Hooks for an engine. The first computation stays at the gate and holds its memory until the gate is
/// opened. Meanwhile the next ones find, one after the other, that they need more than is left.
struct Crowd {
  Gate gate;
  std::atomic<int> cuts{0};
  std::atomic<int> crowdings{1};                             ///< attempts that are still to be crowded out
  std::atomic<std::uint64_t> bytes{std::uint64_t{1} << 40};  ///< the need that they report
  std::atomic<bool> wait{false};                             ///< the others also stop at the gate
  std::function<void(const Execution&)> hold = gate.hook();

  void hook(FakeControl& control) {
    control.during_cut = [this](const Execution& execution) {
      if (cuts++ == 0 || wait) hold(execution);
    };
    control.cut_error = [this]() -> std::optional<Error> {
      if (crowdings.fetch_sub(1) <= 0) return std::nullopt;
      return Error{ErrorCode::kOutOfMemory,
                   "Others hold too much.",
                   {},
                   Figures(nlohmann::json{{"bytes", bytes.load()}})};
    };
  }
};

}  // namespace fracture::test
