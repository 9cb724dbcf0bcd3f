#include "server/bake/plan.hpp"

#include <glob.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <system_error>

#include "common/import/import.hpp"

namespace fracture::bake {
namespace {

namespace fs = std::filesystem;

tl::unexpected<Error> wrong(std::string detail) { return fail(ErrorCode::kBadParameter, std::move(detail)); }

bool is_mesh_name(const fs::path& path) {
  const std::string ending = path.extension().string();
  return ending.size() > 1 && format_from_extension(ending.substr(1)).has_value();
}

bool is_glob(const std::string& text) { return text.find_first_of("*?[") != std::string::npos; }

/// Where the meshes below an input lie, and what their outputs are called below the output folder.
struct Found {
  std::string path;
  fs::path name;
};

Expected<void> add_folder(const std::string& folder, std::vector<Found>& found) {
  std::error_code error;
  for (fs::recursive_directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
    if (at->is_regular_file(error) && is_mesh_name(at->path()))
      found.push_back({at->path().string(), at->path().lexically_relative(folder)});
  if (error) return wrong("The folder '" + folder + "' cannot be read: " + error.message() + ".");
  return {};
}

Expected<void> add_glob(const std::string& pattern, std::vector<Found>& found) {
  glob_t matches{};
  const int result = ::glob(pattern.c_str(), 0, nullptr, &matches);
  for (std::size_t k = 0; result == 0 && k < matches.gl_pathc; ++k) {
    const fs::path path = matches.gl_pathv[k];
    std::error_code error;
    if (fs::is_regular_file(path, error) && is_mesh_name(path))
      found.push_back({path.string(), path.filename()});
  }
  ::globfree(&matches);
  return {};
}

Expected<std::vector<BakeJob>> jobs_of_inputs(const BakeSource& source) {
  std::vector<Found> found;
  for (const std::string& input : source.inputs) {
    const std::size_t before = found.size();
    std::error_code error;
    Expected<void> added;
    if (fs::is_directory(input, error))
      added = add_folder(input, found);
    else if (is_glob(input) && !fs::exists(input, error))
      added = add_glob(input, found);
    else
      found.push_back({input, fs::path(input).filename()});
    if (!added) return tl::unexpected(added.error());
    if (found.size() == before) return wrong("There is no mesh in '" + input + "'.");
  }
  std::sort(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.path < b.path; });
  std::vector<BakeJob> jobs;
  for (const Found& mesh : found)
    jobs.push_back({mesh.path, (fs::path(source.output) / mesh.name).string() + ".glb", source.parameters});
  return jobs;
}

/// Those of the line replace those of the command line of the same name.
void override_by(const nlohmann::json& object, std::vector<RawParameter>& parameters) {
  for (const auto& [name, value] : object.items()) {
    std::erase_if(parameters, [&n = name](const RawParameter& p) { return p.name == n; });
    parameters.push_back({name, value, false});
  }
}

Expected<BakeJob> job_of_line(const std::string& line, const fs::path& folder, const BakeSource& source) {
  const nlohmann::json json = nlohmann::json::parse(line, nullptr, false);
  if (!json.is_object()) return wrong("it is no JSON object");
  BakeJob job{.input = {}, .output = {}, .parameters = source.parameters};
  for (const auto& [key, value] : json.items()) {
    if (key == "input" || key == "output") {
      if (!value.is_string() || value.get_ref<const std::string&>().empty())
        return wrong("'" + key + "' must be a path; it was " + value.dump());
      (key == "input" ? job.input : job.output) =
          (folder / value.get<std::string>()).lexically_normal().string();
    } else if (key == "parameters") {
      if (!value.is_object()) return wrong("'parameters' must be an object; it was " + value.dump());
      override_by(value, job.parameters);
    } else {
      return wrong("'" + key + "' is none of input, output and parameters");
    }
  }
  if (job.input.empty()) return wrong("'input' is missing");
  if (job.output.empty()) return wrong("'output' is missing");
  return job;
}

Expected<std::vector<BakeJob>> jobs_of_manifest(const BakeSource& source) {
  std::ifstream file(source.manifest);
  if (!file) return wrong("The manifest '" + source.manifest + "' cannot be read.");
  const fs::path folder = fs::path(source.manifest).parent_path();
  std::vector<BakeJob> jobs;
  std::string line;
  for (std::size_t number = 1; std::getline(file, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    Expected<BakeJob> job = job_of_line(line, folder, source);
    if (!job)
      return wrong("Line " + std::to_string(number) + " of '" + source.manifest + "': " + job.error().detail +
                   ".");
    jobs.push_back(std::move(*job));
  }
  if (file.bad()) return wrong("The manifest '" + source.manifest + "' cannot be read to its end.");
  return jobs;
}

/// The job that has the same output as an earlier one; two writers of one file would leave either.
const BakeJob* first_collision(const std::vector<BakeJob>& jobs, const BakeJob*& earlier) {
  std::map<std::string, const BakeJob*> by_output;
  for (const BakeJob& job : jobs) {
    const auto [it, fresh] = by_output.emplace(fs::path(job.output).lexically_normal().string(), &job);
    if (!fresh) {
      earlier = it->second;
      return &job;
    }
  }
  return nullptr;
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

Expected<BakePlan> plan_bake(const BakeSource& source) {
  BakePlan plan;
  std::error_code error;
  if (source.manifest.empty() == source.inputs.empty())
    return wrong("Give files, folders or globs, or a --manifest; one of the two.");
  if (!source.manifest.empty()) {
    if (!source.output.empty()) return wrong("A manifest names its outputs itself; leave out --output.");
    Expected<std::vector<BakeJob>> jobs = jobs_of_manifest(source);
    if (!jobs) return tl::unexpected(jobs.error());
    plan.jobs = std::move(*jobs);
  } else {
    if (source.output.empty())
      return wrong("--output is missing: a file for one mesh, a folder for several.");
    const std::string& only = source.inputs.front();
    plan.single = source.inputs.size() == 1 && !fs::is_directory(only, error) &&
                  (!is_glob(only) || fs::exists(only, error)) && source.output.back() != '/' &&
                  !fs::is_directory(source.output, error);
    if (plan.single) {
      plan.jobs.push_back({only, source.output, source.parameters});
    } else {
      Expected<std::vector<BakeJob>> jobs = jobs_of_inputs(source);
      if (!jobs) return tl::unexpected(jobs.error());
      plan.jobs = std::move(*jobs);
    }
  }
  const BakeJob* earlier = nullptr;
  if (const BakeJob* job = first_collision(plan.jobs, earlier))
    return wrong("'" + earlier->input + "' and '" + job->input + "' would both be written to '" +
                 job->output + "'.");
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
        "--shard auto/N: none of FRACTURE_SHARD, JOB_COMPLETION_INDEX and SLURM_ARRAY_TASK_ID says which.");
  const std::size_t count = number_of(std::string_view(text).substr(slash + 1)).value_or(0);
  if (!index || *index >= count) return bad();
  return Shard{*index, count};
}

}  // namespace fracture::bake
