#include "server/bake/manifest.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <utility>

#include "common/base/json_reader.hpp"
#include "common/base/json_text.hpp"
#include "common/base/printable.hpp"
#include "server/bake/input_file.hpp"
#include "server/bake/output_path.hpp"
#include "server/bake/rule_parameters.hpp"
#include "server/bake/sentences.hpp"
#include "server/bake/wrong.hpp"

namespace fracture::bake {
namespace {

namespace fs = std::filesystem;

Expected<BakeJob> job_of_line(const std::string& line, const fs::path& folder, const BakeSource& source) {
  const auto read = read_json(line, {});
  if (!read && read.error().kind != JsonFault::Kind::kSyntax) return wrong("it " + to_text(read.error()));
  if (!read && read.error().at_end)
    return wrong("the line ends before its JSON object is complete (column " +
                 std::to_string(read.error().byte) + "); each line must be one object");
  if (!read) return wrong("it is not a JSON object (column " + std::to_string(read.error().byte) + ")");
  if (!read->value.is_object()) return wrong("it is not a JSON object");
  const nlohmann::json& json = read->value;
  BakeJob job{.input = {}, .output = {}, .parameters = source.parameters};
  for (const auto& [key, value] : json.items()) {
    if (key == "input" || key == "output") {
      if (!value.is_string() || value.get_ref<const std::string&>().empty())
        return wrong("'" + key + "' must be a path; it was " + shortened(json_text(value)));
      if (value == kStandardStream)
        return wrong("'" + key +
                     "' is '-', but a manifest cannot use standard input or output; for a file "
                     "named '-', write './-'");
      std::string path = (folder / value.get<std::string>()).lexically_normal().string();
      if (path == kStandardStream) path.insert(0, "./");
      (key == "input" ? job.input : job.output) = std::move(path);
    } else if (key == "parameters") {
      if (!value.is_object())
        return wrong("'parameters' must be an object; it was " + shortened(json_text(value)));
      for (const auto& [name, given] : value.items()) job.own.push_back({name, given, false});
      put_over(job.own, job.parameters);
    } else {
      return wrong("'" + shortened(key) + "' is not known; only input, output and parameters are allowed");
    }
  }
  if (job.input.empty()) return wrong("'input' is missing");
  if (job.output.empty()) return wrong("'output' is missing");
  return job;
}

/// Returns all error details from the parameter table in one text.
std::string details_of(const Error& error) {
  const auto errors = error.extra->find("errors");
  if (errors == error.extra->end() || !errors->is_array()) return error.detail;
  std::string all;
  for (const nlohmann::json& each : *errors) all += (all.empty() ? "" : " ") + each.value("detail", "");
  return all.empty() ? error.detail : all;
}

/// Checks the job's parameters on their own and combined with each rule. Returns an empty string if all are
/// valid.
std::string fault_of(const BakeJob& job, const RuleFile& rules, const ParseParameters& parse) {
  const Expected<RequestParameters> parsed = parse(job.parameters);
  if (parsed) return {};
  for (std::size_t k = 0; k < rules.rules.size(); ++k)
    if (parse(parameters_of(job, rules, {RuleMatch{k, {}}}).all)) return {};
  return details_of(parsed.error());
}

}  // namespace

Expected<std::vector<BakeJob>> read_manifest(const BakeSource& source, LineFaults& faults) {
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
    if (!job) {
      faults.add(number, job.error().detail + ".");
      continue;
    }
    job->line = number;
    jobs.push_back(std::move(*job));
  }
  if (file.bad())
    return wrong("The manifest '" + source.manifest +
                 "' cannot be read to the end: " + std::strerror(errno != 0 ? errno : EIO) + ".");
  if (jobs.empty() && faults.empty())
    return wrong("The manifest '" + source.manifest +
                 "' has no jobs. Write one line for each job, such as "
                 "{\"input\": \"oak.glb\", \"output\": \"broken/oak.glb\"}.");
  return jobs;
}

void check_parameters(const std::vector<BakeJob>& jobs, const RuleFile& rules, const ParseParameters& parse,
                      LineFaults& faults) {
  std::map<std::string, std::string> fault_of_parameters;  // few distinct sets, even for many lines
  for (const BakeJob& job : jobs) {
    nlohmann::json key = nlohmann::json::array();
    for (const RawParameter& parameter : job.own) key.push_back({parameter.name, parameter.value});
    const auto [at, fresh] = fault_of_parameters.try_emplace(json_text(key));
    if (fresh) at->second = fault_of(job, rules, parse);
    if (!at->second.empty()) faults.add(job.line, at->second);
  }
}

void check_inputs(const std::vector<BakeJob>& jobs, LineFaults& faults) {
  for (const BakeJob& job : jobs) {
    if (job.line == 0) continue;
    if (const std::optional<std::string> fault = fault_of_input(job.input))
      faults.add(job.line, "warning: cannot read " + name_of_input(job.input) + ": " + *fault + ".");
  }
}

}  // namespace fracture::bake
