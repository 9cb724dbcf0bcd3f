// Runs the jobs of a bake, from one to a hundred thousand: reads, calls a Baker, checks, writes and reports.
#pragma once

#include <cstddef>
#include <functional>
#include <stop_token>
#include <string>

#include "server/bake/baker.hpp"
#include "server/bake/plan.hpp"
#include "server/bake/preview.hpp"
#include "server/service/failure_keeper.hpp"

namespace fracture::bake {

struct RunOptions {
  int jobs = 1;                       ///< number at the same time
  int threads = 1;                    ///< per job; the output bytes do not depend on it
  std::string report;                 ///< path of the NDJSON report; empty: none
  std::string depfile;                ///< for a single job: see depfile.hpp; empty: none
  std::string stages;                 ///< folder to which the baker dumps its stages; empty: none
  bool force = false;                 ///< make outputs again even if they are up to date
  bool quiet = false;                 ///< print no progress and no notes, only refusals and warnings
  FailureKeeper* failures = nullptr;  ///< stores unsound answers and bugs; null: not stored
  Previews* previews = nullptr;       ///< draws the pictures of jobs that have one; null: no pictures
  std::string title;                  ///< of the plan's page
  std::string no_pictures;            ///< a sentence: why the page has no pictures; empty if it has
};

struct RunFigures {
  std::size_t made = 0;
  std::size_t kept = 0;     ///< up to date: same key, and the file still has the digest in the report
  std::size_t refused = 0;  ///< because of their inputs or parameters
  std::size_t failed = 0;   ///< because of bugs or lack of memory
  std::size_t unsound = 0;  ///< answers that fail their own checks; not written
  std::size_t unreadable = 0, unwritable = 0;
  std::size_t unavailable = 0;  ///< 1: the baker gave up on its server
  std::size_t cancelled = 0;    ///< not completed when a stop was requested or the baker gave up
  bool begun = false;           ///< false if some path is not writable, so that no job was started
  std::string sentence;  ///< for a single job (BakePlan::single): its result; empty if reported as an error
};

/// Returns when every job is done, a stop is requested, or the baker is unavailable. Returns at once if the
/// report or a needed folder is not writable; all such paths are counted. Each output is written
/// completely or not at all, and only if its certificate holds. Errors and the warnings of answers are
/// printed to standard error.
RunFigures run_bake(const BakePlan& plan, Baker& baker, const RunOptions& options,
                    const std::stop_token& stop);

}  // namespace fracture::bake
