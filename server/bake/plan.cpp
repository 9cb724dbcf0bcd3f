#include "server/bake/plan.hpp"

#include <glob.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <system_error>
#include <utility>

#include "common/base/json_reader.hpp"
#include "common/base/json_text.hpp"
#include "common/base/printable.hpp"
#include "common/import/import_input.hpp"
#include "server/bake/html_report.hpp"
#include "server/bake/output_files.hpp"
#include "server/bake/output_path.hpp"
#include "server/bake/picture_paths.hpp"
#include "server/bake/report.hpp"
#include "server/bake/result_file.hpp"
#include "server/bake/stage_dump.hpp"

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

/// Looks for meshes, and leaves out what earlier bakes made.
class Search {
 public:
  explicit Search(const BakeSource& source) : source_(source) {
    if (!source.report.empty()) add_results_of_report(source.report, results_);
  }

  Expected<void> look_into(const std::string& input) {
    std::error_code error;
    const std::size_t before = found_.size(), skipped_before = skipped_.size();
    Expected<void> looked;
    if (fs::is_directory(input, error))
      looked = look_into_folder(input);
    else if (is_glob(input) && !fs::exists(input, error))
      look_into_glob(input);
    else
      found_.push_back({input, fs::path(input).filename()});
    if (looked && found_.size() == before) {
      const std::size_t results = skipped_.size() - skipped_before;
      return wrong("There is no mesh in '" + input + "'" +
                   (results > 0 ? " but " + std::to_string(results) + " that earlier bakes made." : "."));
    }
    return looked;
  }

  std::vector<Found> take_found() { return std::move(found_); }
  std::vector<std::string> take_skipped() { return std::move(skipped_); }

 private:
  Expected<void> look_into_folder(const std::string& folder) {
    std::vector<Found> meshes;
    std::error_code error;
    for (fs::recursive_directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
      const fs::path& path = at->path();
      if (at->is_directory(error)) {
        if (!source_.failures.empty() && identity_of(path.string()) == identity_of(source_.failures))
          at.disable_recursion_pending();
      } else if (at->is_regular_file(error)) {
        if (is_mesh_name(path))
          meshes.push_back({path.string(), path.lexically_relative(folder)});
        else if (const std::string name = path.filename().string();
                 name.starts_with("bake.") && name.ends_with(".ndjson"))
          add_results_of_report(path.string(), results_);
      }
    }
    if (error) return wrong("The folder '" + folder + "' cannot be read: " + error.message() + ".");
    for (Found& mesh : meshes) add(std::move(mesh));
    return {};
  }

  void look_into_glob(const std::string& pattern) {
    glob_t matches{};
    const int result = ::glob(pattern.c_str(), 0, nullptr, &matches);
    for (std::size_t k = 0; result == 0 && k < matches.gl_pathc; ++k) {
      const fs::path path = matches.gl_pathv[k];
      std::error_code error;
      if (fs::is_regular_file(path, error) && is_mesh_name(path)) add({path.string(), path.filename()});
    }
    ::globfree(&matches);
  }

  void add(Found mesh) {
    const std::optional<MeshFormat> format =
        format_from_extension(fs::path(mesh.path).extension().string().substr(1));
    const bool result = (!results_.empty() && results_.contains(identity_of(mesh.path))) ||
                        (format && is_result_file(mesh.path, *format));
    if (result)
      skipped_.push_back(mesh.path);
    else
      found_.push_back(std::move(mesh));
  }

  const BakeSource& source_;
  std::set<FileIdentity> results_;  ///< by the reports of earlier bakes
  std::vector<Found> found_;
  std::vector<std::string> skipped_;
};

Expected<std::vector<BakeJob>> jobs_of_inputs(const BakeSource& source, std::vector<std::string>& skipped) {
  std::error_code error;
  const bool there = fs::exists(source.output, error),
             file = there && !fs::is_directory(source.output, error);
  const bool named_as_one = fs::path(source.output).has_extension() && kind_of_output(source.output);
  if (file || (!there && named_as_one))
    return wrong("'" + source.output + "' is " + (file ? "no folder" : "the name of a file") +
                 ": several meshes, or those of a folder, need a folder (a new one may end in '/').");
  Search search(source);
  for (const std::string& input : source.inputs) {
    if (input == kStandardStream)
      return wrong(
          "Standard input ('-') is one mesh, and goes alone to one file: give it a name with --output.");
    if (const auto looked = search.look_into(input); !looked) return tl::unexpected(looked.error());
  }
  skipped = search.take_skipped();
  std::vector<Found> found = search.take_found();
  std::sort(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.path < b.path; });
  std::vector<BakeJob> jobs;
  for (const Found& mesh : found)
    jobs.push_back({mesh.path, (fs::path(source.output) / mesh.name).string() + ".glb", source.parameters});
  return jobs;
}

Expected<BakeJob> job_of_line(const std::string& line, const fs::path& folder, const BakeSource& source) {
  const auto read = read_json(line, {});
  if (!read && read.error().kind != JsonFault::Kind::kSyntax) return wrong("it " + to_text(read.error()));
  if (!read) return wrong("it is no JSON object (column " + std::to_string(read.error().byte) + ")");
  if (!read->value.is_object()) return wrong("it is no JSON object");
  const nlohmann::json& json = read->value;
  BakeJob job{.input = {}, .output = {}, .parameters = source.parameters};
  for (const auto& [key, value] : json.items()) {
    if (key == "input" || key == "output") {
      if (!value.is_string() || value.get_ref<const std::string&>().empty())
        return wrong("'" + key + "' must be a path; it was " + shortened(json_text(value)));
      if (value == kStandardStream)
        return wrong("'" + key +
                     "' is '-': standard input and output are for one mesh without a manifest; a file "
                     "of this name is './-'");
      std::string path = (folder / value.get<std::string>()).lexically_normal().string();
      if (path == kStandardStream) path.insert(0, "./");
      (key == "input" ? job.input : job.output) = std::move(path);
    } else if (key == "parameters") {
      if (!value.is_object())
        return wrong("'parameters' must be an object; it was " + shortened(json_text(value)));
      for (const auto& [name, given] : value.items()) job.own.push_back({name, given, false});
      put_over(job.own, job.parameters);
    } else {
      return wrong("'" + shortened(key) + "' is none of input, output and parameters");
    }
  }
  if (job.input.empty()) return wrong("'input' is missing");
  if (job.output.empty()) return wrong("'output' is missing");
  return job;
}

Expected<std::vector<BakeJob>> jobs_of_manifest(const BakeSource& source) {
  errno = 0;
  std::ifstream file(source.manifest);
  if (!file)
    return wrong("The manifest '" + source.manifest + "' cannot be read: " + std::strerror(errno) + ".");
  const fs::path folder = fs::path(source.manifest).parent_path();
  std::vector<BakeJob> jobs;
  std::string line;
  for (std::size_t number = 1; std::getline(file, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    Expected<BakeJob> job = job_of_line(line, folder, source);
    if (!job)
      return wrong("Line " + std::to_string(number) + " of '" + source.manifest + "': " + job.error().detail +
                   ".");
    job->line = number;
    jobs.push_back(std::move(*job));
  }
  if (file.bad())
    return wrong("The manifest '" + source.manifest +
                 "' cannot be read to its end: " + std::strerror(errno != 0 ? errno : EIO) + ".");
  return jobs;
}

/// Finds whatever a bake would lose by writing.
class Places {
 public:
  /// What is read stays.
  void read(const std::string& path, const std::string& what) {
    if (path != kStandardStream) read_.emplace(identity_of(path), what + " '" + path + "'");
  }
  /// kBadParameter where it may not be written. `whose`: the mesh that becomes this output, or what else this is.
  Expected<void> write(const std::string& path, const std::string& whose) {
    if (path == kStandardStream) return {};
    if (std::optional<Error> refused = refuse_output(path)) return tl::unexpected<Error>(std::move(*refused));
    const FileIdentity identity = identity_of(path);
    if (const auto at = read_.find(identity); at != read_.end())
      return wrong("'" + path + "' would be written over " + at->second + ".");
    if (const auto [at, fresh] = written_.emplace(identity, whose); !fresh)
      return wrong(at->second + " and " + whose + " would both be written to '" + path + "'.");
    return {};
  }

 private:
  std::map<FileIdentity, std::string> read_, written_;  ///< with words for them
};

Expected<void> lose_nothing(const BakePlan& plan, const BakeSource& source) {
  Places places;
  for (const BakeJob& job : plan.jobs) places.read(job.input, "the input");
  if (!source.manifest.empty()) places.read(source.manifest, "the manifest");
  if (!source.rules.empty()) places.read(source.rules, "the rules");
  for (const BakeJob& job : plan.jobs) {
    const auto in_line = [&](const std::string& detail) {
      return wrong(
          (job.line > 0 ? "Line " + std::to_string(job.line) + " of '" + source.manifest + "': " : "") +
          detail);
    };
    if (job.output != kStandardStream)
      if (const auto kind = kind_of_output(job.output); !kind) return in_line(kind.error().detail);
    if (const auto place = places.write(job.output, "'" + job.input + "'"); !place)
      return in_line(place.error().detail);
    const std::string materials = materials_beside(job.output);
    if (materials.empty()) continue;
    if (const auto place = places.write(materials, "the materials of '" + job.output + "'"); !place)
      return in_line(place.error().detail);
    if (is_foreign_mtl(materials))
      return in_line("'" + materials + "' is there, and no bake made it: the materials of '" + job.output +
                     "' would be written over it.");
  }
  for (const BakeJob& job : plan.jobs)
    if (!job.picture.empty())
      if (auto place = places.write(job.picture, "the picture of '" + job.output + "'"); !place) return place;
  if (!plan.html.empty()) {
    if (auto place = places.write(plan.html, "the page"); !place) return place;
    if (!may_be_html_report(plan.html))
      return wrong("'" + plan.html + "' is there and is no page of a bake; as one it would be written anew.");
  }
  if (!plan.report.empty()) {
    if (plan.report == kStandardStream)
      return wrong("--report needs a file: it is read again by the next bake.");
    if (auto place = places.write(plan.report, "the report"); !place) return place;
    if (!BakeReport::may_be(plan.report))
      return wrong("'" + plan.report +
                   "' is there and is no report of a bake; as one it would be written anew.");
  }
  if (!source.depfile.empty()) {
    if (source.depfile == kStandardStream || plan.jobs.front().output == kStandardStream ||
        plan.jobs.front().input == kStandardStream)
      return wrong("--depfile is a file that names files: it does not go with '-'.");
    if (auto place = places.write(source.depfile, "the depfile"); !place) return place;
  }
  if (source.stages.empty()) return {};
  for (const std::string& path : stage_files(source.stages)) {
    std::error_code error;
    if (fs::exists(fs::symlink_status(path, error)))
      return wrong("'" + path + "' is there already, and --dump-stages writes over nothing.");
    if (auto place = places.write(path, "a stage"); !place) return place;
  }
  return {};
}

/// Beside the outputs, or beside the manifest; one for each shard.
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

Expected<BakePlan> plan_bake(const BakeSource& given) {
  BakePlan plan;
  BakeSource source = given;
  std::error_code error;
  if (source.manifest.empty() == source.inputs.empty())
    return wrong("Give files, folders or globs, or a --manifest; one of the two.");
  if (source.manifest.empty()) {
    if (source.output.empty())
      return wrong("--output is missing: a file for one mesh, a folder for several.");
    const std::string& only = source.inputs.front();
    plan.single = source.inputs.size() == 1 && !fs::is_directory(only, error) &&
                  (!is_glob(only) || fs::exists(only, error)) && source.output.back() != '/' &&
                  !fs::is_directory(source.output, error);
    if (!plan.single && source.output == kStandardStream)
      return wrong("Standard output ('-') takes the fragments of one mesh.");
  } else if (!source.output.empty()) {
    return wrong("A manifest names its outputs itself; leave out --output.");
  }
  if (!source.depfile.empty() && !plan.single) return wrong("--depfile is for one mesh to one file.");
  if (!source.stages.empty() && !plan.single) return wrong("--dump-stages is for one mesh to one file.");
  if (source.report.empty() && !plan.single) source.report = report_beside(source);
  plan.report = source.report;

  if (!source.rules.empty()) {
    Expected<RuleFile> rules = read_rules(source.rules);
    if (!rules) return tl::unexpected(rules.error());
    plan.rules = std::move(*rules);
  }
  if (plan.single) {
    plan.jobs.push_back({source.inputs.front(), source.output, source.parameters});
  } else {
    Expected<std::vector<BakeJob>> jobs =
        source.manifest.empty() ? jobs_of_inputs(source, plan.skipped) : jobs_of_manifest(source);
    if (!jobs) return tl::unexpected(jobs.error());
    plan.jobs = std::move(*jobs);
  }
  plan.html = page_of(source);
  if (const auto pictures = give_pictures(source, plan.single, plan.jobs); !pictures)
    return tl::unexpected(pictures.error());
  if (const auto safe = lose_nothing(plan, source); !safe) return tl::unexpected(safe.error());
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
