// What a bake is to make: from files, folders, globs or a manifest to a list of jobs, in an order that
// depends on nothing but the names.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/parameters/parameters.hpp"
#include "server/bake/rules.hpp"

namespace fracture::bake {

struct BakeJob {
  std::string input, output;  ///< paths, or kStandardStream
  std::vector<RawParameter>
      parameters;                   ///< those of the command line, and over them those of the manifest's line
  std::size_t line = 0;             ///< of the manifest, from 1; 0: of none
  std::vector<RawParameter> own{};  ///< those of the manifest's line alone: they go over those of rules, too
  std::string picture{};            ///< PNG to draw of the output; empty: none
};

/// Every count-th job, beginning with the index-th (0 ... count - 1).
struct Shard {
  std::size_t index = 0, count = 1;
};

struct BakeSource {
  std::vector<std::string> inputs{};  ///< files, folders (all meshes below them) and globs ("assets/*.glb")
  std::string manifest{};  ///< NDJSON: {"input": ..., "output": ..., "parameters": {...}} on each line
  std::string output{};    ///< a file for one file, else a folder
  std::vector<RawParameter> parameters{};  ///< of all jobs
  Shard shard{};
  std::string rules{};     ///< JSON (rules.hpp); empty: none
  std::string report{};    ///< empty: beside the outputs or the manifest, and none for one file to one file
  std::string depfile{};   ///< empty: none
  std::string failures{};  ///< folder of kept failures, in which no meshes are looked for; empty: none
  std::string stages{};    ///< folder for stage_dump.hpp; empty: none
  std::string preview{};   ///< PNG for one file, else a folder (picture_paths.hpp); empty: none
  std::string html{};      ///< page to write (html_report.hpp); empty: none
};

struct BakePlan {
  std::vector<BakeJob> jobs;  ///< of the shard
  std::size_t all = 0;        ///< jobs of all shards
  bool single = false;        ///< one file to one file: the words of one
  RuleFile rules{};
  std::string report;                ///< path; empty: none
  std::string html{};                ///< path of the page; empty: none
  std::vector<std::string> skipped;  ///< results of earlier bakes that lie below the inputs
};

/// A folder's mesh sub/barrel.obj becomes <output>/sub/barrel.obj.glb, whatever lies beside it. Paths in a
/// manifest are relative to its folder. What earlier bakes made (result_file.hpp) is no mesh of a folder or a
/// glob; it is where it is named.
///
/// Nothing is lost: no output, picture, report, page or depfile of any shard is an input, the manifest, the rules, another one of them,
/// or a place where no file can be; and what a dump of stages would write is not there yet. With `parse` the parameters of each line of
/// the manifest are right, whatever its mesh. Errors: kBadParameter, which names every wrong line of the manifest, and the paths;
/// nothing matches or is readable: kBadParameter too.
Expected<BakePlan> plan_bake(const BakeSource& source, const ParseParameters& parse = {});

/// "3/16", or "auto/16": the index that an orchestrator gives in JOB_COMPLETION_INDEX (Kubernetes),
/// SLURM_ARRAY_TASK_ID less SLURM_ARRAY_TASK_MIN, or FRACTURE_SHARD. Errors: kBadParameter.
Expected<Shard> parse_shard(const std::string& text);

}  // namespace fracture::bake
