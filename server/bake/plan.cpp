#include "server/bake/plan.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

#include "server/bake/manifest.hpp"
#include "server/bake/mesh_search.hpp"
#include "server/bake/output_path.hpp"
#include "server/bake/picture_paths.hpp"
#include "server/bake/report.hpp"
#include "server/bake/safe_places.hpp"
#include "server/bake/wrong.hpp"

namespace fracture::bake {
namespace {

namespace fs = std::filesystem;

Expected<std::vector<BakeJob>> jobs_of_inputs(const BakeSource& source, BakePlan& plan) {
  std::error_code error;
  const bool there = fs::exists(source.output, error),
             file = there && !fs::is_directory(source.output, error);
  const bool named_as_one = fs::path(source.output).has_extension() && kind_of_output(source.output);
  if (file || (!there && named_as_one))
    return wrong("'" + source.output + "' is " + (file ? "not a folder" : "the name of a file") +
                 ": several meshes, or the meshes in a folder, need an output folder (end the name of a new "
                 "folder with '/').");
  MeshSearch search;
  if (!source.report.empty()) search.add_report(source.report);
  if (!source.failures.empty()) search.leave_out(source.failures);
  for (const std::string& input : source.inputs) {
    if (input == kStandardStream)
      return wrong(
          "Standard input ('-') contains one mesh, so it must be the only input: name one output file with --output.");
    if (const auto looked = search.look_into(input); !looked) return tl::unexpected(looked.error());
  }
  plan.skipped = search.skipped();
  // The first shard reports them for all shards.
  if (source.shard.index == 0) plan.dangling = search.dangling();
  std::vector<BakeJob> jobs;
  for (const FoundMesh& mesh : search.found())
    jobs.push_back({mesh.path, (fs::path(source.output) / mesh.name).string() + ".glb", source.parameters});
  return jobs;
}

/// Returns the default report path: in the output folder or next to the manifest, one for each shard.
std::string report_beside(const BakeSource& source) {
  const std::string part = part_of(source.shard);
  return source.manifest.empty() ? source.output + "/bake" + part + ".ndjson"
                                 : source.manifest + part + ".report";
}

std::optional<std::size_t> number_of(std::string_view text) {
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<std::size_t> variable(const char* name) {
  const char* text = std::getenv(name);
  return text ? number_of(text) : std::nullopt;
}

std::optional<std::size_t> index_of_orchestrator() {
  if (const auto index = variable("FRACTURE_SHARD")) return index;
  if (const auto index = variable("JOB_COMPLETION_INDEX")) return index;
  if (const auto index = variable("SLURM_ARRAY_TASK_ID")) {
    const std::size_t first = variable("SLURM_ARRAY_TASK_MIN").value_or(0);
    if (*index >= first) return *index - first;
  }
  return std::nullopt;
}

}  // namespace

Expected<BakePlan> plan_bake(const BakeSource& given, const ParseParameters& parse) {
  BakePlan plan;
  BakeSource source = given;
  std::error_code error;
  if (source.manifest.empty() && source.inputs.empty())
    return wrong("Give mesh files, folders or globs, or a --manifest. Run fracture-server bake --help.");
  if (!source.manifest.empty() && !source.inputs.empty())
    return wrong("Give either input paths (files, folders, globs) or a --manifest, but not both.");
  if (source.manifest.empty()) {
    if (source.output.empty())
      return wrong("--output is missing: give a file for one mesh, or a folder for several.");
    const std::string& only = source.inputs.front();
    plan.single = source.inputs.size() == 1 && !stands_for_many(only) && source.output.back() != '/' &&
                  !fs::is_directory(source.output, error);
    if (!plan.single && source.output == kStandardStream)
      return wrong(
          "Standard output ('-') can take the fragments of only one mesh: give a folder with --output.");
  } else if (!source.output.empty()) {
    return wrong("A manifest lists its own outputs: leave out --output.");
  }
  if (!source.depfile.empty() && !plan.single)
    return wrong("--depfile requires exactly one mesh and one output file.");
  if (!source.stages.empty() && !plan.single)
    return wrong("--dump-stages requires exactly one mesh and one output file.");
  if (source.report.empty() && !plan.single) source.report = report_beside(source);
  plan.manifest = source.manifest;
  plan.report = source.report;

  if (!source.rules.empty()) {
    Expected<RuleFile> rules = read_rules(source.rules);
    if (!rules) return tl::unexpected(rules.error());
    plan.rules = std::move(*rules);
  }
  LineFaults faults(source.manifest);
  if (plan.single) {
    plan.jobs.push_back({source.inputs.front(), source.output, source.parameters});
  } else {
    Expected<std::vector<BakeJob>> jobs =
        source.manifest.empty() ? jobs_of_inputs(source, plan) : read_manifest(source, faults);
    if (!jobs) return tl::unexpected(jobs.error());
    plan.jobs = std::move(*jobs);
  }
  plan.html = page_of(source);
  if (const auto pictures = give_pictures(source, plan.single, plan.jobs); !pictures)
    return tl::unexpected(pictures.error());
  const Expected<void> safe = check_places(plan, source, faults);
  if (!source.manifest.empty() && parse) check_parameters(plan.jobs, plan.rules, parse, faults);
  if (!faults.empty()) return tl::unexpected(faults.error());
  if (!safe) return tl::unexpected(safe.error());
  plan.all = plan.jobs.size();
  if (source.shard.count > 1) {
    std::vector<BakeJob> mine;
    for (std::size_t k = source.shard.index; k < plan.jobs.size(); k += source.shard.count)
      mine.push_back(std::move(plan.jobs[k]));
    plan.jobs = std::move(mine);
  }
  return plan;
}

Expected<Shard> parse_shard(const std::string& text) {
  const auto bad = [&] {
    return wrong("--shard must be I/N with 0 <= I < N, or auto/N; it was '" + text + "'.");
  };
  const std::size_t slash = text.find('/');
  if (slash == std::string::npos) return bad();
  const std::string first = text.substr(0, slash);
  const std::optional<std::size_t> index = first == "auto" ? index_of_orchestrator() : number_of(first);
  if (first == "auto" && !index)
    return wrong(
        "--shard auto/N needs a shard number in FRACTURE_SHARD, JOB_COMPLETION_INDEX or SLURM_ARRAY_TASK_ID.");
  const std::size_t count = number_of(std::string_view(text).substr(slash + 1)).value_or(0);
  if (!index || *index >= count) return bad();
  return Shard{*index, count};
}

}  // namespace fracture::bake
