// Plans a bake: turns files, folders, globs or a manifest into a list of jobs. Their order depends only on
// the names.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/parameters/parameters.hpp"
#include "server/bake/rules.hpp"

namespace fracture::bake {

struct BakeJob {
  std::string input, output;             ///< paths, or kStandardStream
  std::vector<RawParameter> parameters;  ///< of the command line, overridden by those of the manifest line
  std::size_t line = 0;                  ///< in the manifest, starting at 1; 0: not from a manifest
  std::vector<RawParameter> own{};       ///< of the manifest line alone: they also override rules
  std::string picture{};                 ///< PNG to draw of the output; empty: none
};

/// Selects every count-th job, starting at job `index` (0 ... count - 1).
struct Shard {
  std::size_t index = 0, count = 1;
};

struct BakeSource {
  std::vector<std::string> inputs{};  ///< files, folders (all meshes below them) and globs ("assets/*.glb")
  std::string manifest{};  ///< NDJSON: {"input": ..., "output": ..., "parameters": {...}} on each line
  std::string output{};    ///< a file for one file, else a folder
  std::vector<RawParameter> parameters{};  ///< for all jobs
  Shard shard{};
  std::string rules{};     ///< JSON (rules.hpp); empty: none
  std::string report{};    ///< empty: default path, but none for a single file
  std::string depfile{};   ///< empty: none
  std::string failures{};  ///< folder of kept failures, not searched for meshes; empty: none
  std::string stages{};    ///< folder for stage_dump.hpp; empty: none
  std::string preview{};   ///< PNG for one file, else a folder (picture_paths.hpp); empty: none
  std::string html{};      ///< page to write (html_report.hpp); empty: none
};

struct BakePlan {
  std::vector<BakeJob> jobs;  ///< of this shard
  std::size_t all = 0;        ///< number of jobs in all shards
  bool single = false;        ///< one input file and one output file: messages are about one file
  RuleFile rules{};
  std::string manifest{};            ///< path; empty: none
  std::string report;                ///< path; empty: none
  std::string html{};                ///< path of the page; empty: none
  std::vector<std::string> skipped;  ///< paths of results of earlier bakes found in the inputs
  /// Links without a target in the inputs (mesh_search.hpp); of all shards, in the first one.
  std::vector<std::string> dangling{};
};

/// Plans a bake. A folder's mesh sub/barrel.obj becomes <output>/sub/barrel.obj.glb, whatever other meshes
/// are next to it. Paths in a manifest are relative to its folder. Results of earlier bakes (result_file.hpp)
/// are skipped in folders and globs, but not if they are named directly. Links to folders are followed
/// (mesh_search.hpp).
///
/// No file is lost: an output, picture, report, page or depfile of any shard never replaces an input, the
/// manifest, the rules or another of these files, and --dump-stages writes only new files. With `parse`, the
/// parameters of each manifest line are checked, whatever its mesh. Returns kBadParameter with every faulty
/// line of the manifest and the paths concerned, and also if nothing matches or can be read.
Expected<BakePlan> plan_bake(const BakeSource& source, const ParseParameters& parse = {});

/// Parses "3/16" or "auto/16". With "auto", the index comes from the orchestrator: JOB_COMPLETION_INDEX
/// (Kubernetes), SLURM_ARRAY_TASK_ID minus SLURM_ARRAY_TASK_MIN, or FRACTURE_SHARD. Returns kBadParameter on
/// errors.
Expected<Shard> parse_shard(const std::string& text);

}  // namespace fracture::bake
