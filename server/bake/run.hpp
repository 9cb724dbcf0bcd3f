// Does the jobs of a bake, one or a hundred thousand: reads, asks a Baker, judges, writes, reports.
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
  int jobs = 1;                       ///< at the same time
  int threads = 1;                    ///< of each; the bytes do not depend on it
  std::string report;                 ///< path of the NDJSON report; empty: none
  std::string depfile;                ///< for one job: see depfile.hpp; empty: none
  bool force = false;                 ///< make outputs again that are right already
  bool quiet = false;                 ///< no progress and no notes, but refusals and warnings
  FailureKeeper* failures = nullptr;  ///< gets what is unsound or a bug; null: nobody does
  Previews* previews = nullptr;       ///< draws the picture of each job that has one; null: nobody does
  std::string title;                  ///< of the plan's page
  std::string no_pictures;            ///< why the page has none, a sentence; empty: it has
};

struct RunFigures {
  std::size_t made = 0;
  std::size_t kept = 0;     ///< right already: same key, and the file has the bytes that the report says
  std::size_t refused = 0;  ///< inputs or parameters
  std::size_t failed = 0;   ///< bugs, and lack of memory
  std::size_t unsound = 0;  ///< answers that do not prove themselves: not written
  std::size_t unreadable = 0, unwritable = 0;
  std::size_t unavailable = 0;  ///< 1: the baker gave up on its server
  std::size_t cancelled = 0;    ///< not done, or not to the end, when the stop came or the baker gave up
  bool begun = false;           ///< false: something cannot be written to, so that no job was begun
  std::string
      sentence;  ///< of a single job (BakePlan::single): what became of it; empty: that was said as an error
};

/// Returns when every job is done, the stop came, or the baker is unavailable; at once, with all that is unwritable counted,
/// if the report or the folder of an output that no earlier run made cannot be written to. Each output is written whole
/// or not at all, and only when its certificate holds. What is wrong, and what the answers warn of, is said
/// on standard error.
RunFigures run_bake(const BakePlan& plan, Baker& baker, const RunOptions& options,
                    const std::stop_token& stop);

}  // namespace fracture::bake
