// Writes jobs to disk, as disk work: the mesh and the request, and the outcome.
#include "server/jobs/jobs.hpp"

namespace fracture {

void Jobs::persist(const Shared& job, const FractureRequest& request) {
  JobRecord record;
  std::shared_ptr<const FractureAnswer> answer;
  {
    const std::lock_guard lock(mutex_);
    if (!job->kept) return;  // already cancelled and forgotten
    if (job->view.finished() && !job->view.answer) return;
    record = job->record;
    answer = job->view.answer;
  }
  // If the job is already done, only its outcome is written. If that fails, the request is written instead.
  bool there = answer && write_end(job, record, answer);
  if (!there) {
    record.state = JobState::kQueued;
    record.finished_at.reset();
    record.parameters = canonical_parameters(request.parameters);
    there = folder_->write(record, request);
  }
  if (!there) return not_durable(job);
  const std::lock_guard lock(mutex_);
  job->view.durable = job->kept;
  if (job->kept) job->request.reset();
}

void Jobs::not_durable(const Shared& job) {
  {
    const std::lock_guard lock(mutex_);
    job->kept = job->view.durable = false;
    unpin(*job);
  }
  folder_->remove(job->view.id);
}

void Jobs::persist_end(const Shared& job, const std::shared_ptr<const FractureAnswer>& answer) {
  /// Says at the end that the disk work has the result no longer.
  struct AtEnd {
    Jobs& jobs;
    const Shared& job;
    ~AtEnd() {
      const std::lock_guard lock(jobs.mutex_);
      job->writes_end = false;
    }
  } const at_end{*this, job};
  JobRecord record;
  bool marked = false;
  {
    const std::lock_guard lock(mutex_);
    if (!job->kept) return;
    record = job->record;
    marked = std::exchange(job->marked, false);
  }
  // If the disk tier has no room for the answer, the request stays on disk, and the job is computed again
  // after a restart.
  if (!write_end(job, record, answer)) {
    if (marked) folder_->not_begun(record.id);
    return;
  }
  const std::lock_guard lock(mutex_);
  job->view.durable = job->kept;
}

bool Jobs::write_end(const Shared& job, const JobRecord& record,
                     const std::shared_ptr<const FractureAnswer>& answer) {
  if (job->written_end) return true;
  if (answer && !keep_result(job, answer->result)) return false;
  job->written_end = folder_->write_end(record);
  if (job->written_end) return true;
  const std::lock_guard lock(mutex_);
  unpin(*job);
  return false;
}

bool Jobs::keep_result(const Shared& job, const std::shared_ptr<const FractureResult>& result) {
  ResultTiers& tiers = dispatcher_.service().tiers();
  /// Pins the result while it is written, so that others cannot evict it before it is charged.
  struct Pin {
    ResultTiers& tiers;
    const std::string& key;
    bool charged = false;
    explicit Pin(ResultTiers& its_tiers, const std::string& its_key) : tiers(its_tiers), key(its_key) {
      tiers.pin(key);
    }
    ~Pin() {
      if (!charged) tiers.unpin(key);
    }
  } pin(tiers, result->key);
  if (!tiers.keep_on_disk(result)) return false;
  const std::uint64_t bytes = tiers.bytes_on_disk(result->key);
  const std::lock_guard lock(mutex_);
  pin.charged = true;  // also if charge_pin() throws: it charges first
  pin.charged = charge_pin(*job, bytes);
  return true;
}

}  // namespace fracture
