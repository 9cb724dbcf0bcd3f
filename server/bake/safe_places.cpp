#include "server/bake/safe_places.hpp"

#include <filesystem>
#include <map>
#include <optional>
#include <system_error>
#include <utility>

#include "server/bake/html_report.hpp"
#include "server/bake/output_files.hpp"
#include "server/bake/output_path.hpp"
#include "server/bake/report.hpp"
#include "server/bake/stage_dump.hpp"
#include "server/bake/wrong.hpp"

namespace fracture::bake {
namespace {

namespace fs = std::filesystem;

/// Finds files that a bake would overwrite.
class Places {
 public:
  /// Registers an input file, which must not be overwritten.
  void read(const std::string& path, const std::string& what) {
    if (path != kStandardStream) read_.emplace(identity_of(path), what + " '" + path + "'");
  }
  /// Registers a file to be written. Returns kBadParameter if it must not be. `whose` names the mesh of this
  /// output, or the kind of file.
  Expected<void> write(const std::string& path, const std::string& whose) {
    if (path == kStandardStream) return {};
    if (std::optional<Error> refused = refuse_output(path)) return tl::unexpected<Error>(std::move(*refused));
    const FileIdentity identity = identity_of(path);
    if (const auto at = read_.find(identity); at != read_.end())
      return wrong("Writing '" + path + "' would overwrite " + at->second + ": choose another path.");
    if (const auto [at, fresh] = written_.emplace(identity, whose); !fresh)
      return wrong(at->second + " and " + whose + " would both be written to '" + path + "'.");
    return {};
  }

 private:
  std::map<FileIdentity, std::string> read_, written_;  ///< with their descriptions for messages
};

Expected<void> check_output(const BakeJob& job, Places& places) {
  if (job.output != kStandardStream)
    if (const auto kind = kind_of_output(job.output); !kind) return tl::unexpected(kind.error());
  if (auto place = places.write(job.output, "'" + job.input + "'"); !place) return place;
  const std::string materials = materials_beside(job.output);
  if (materials.empty()) return {};
  if (auto place = places.write(materials, "the materials of '" + job.output + "'"); !place) return place;
  if (is_foreign_mtl(materials))
    return wrong("'" + materials + "' was not made by a bake, and the materials of '" + job.output +
                 "' would overwrite it: move it or choose another output.");
  return {};
}

}  // namespace

Expected<void> check_places(const BakePlan& plan, const BakeSource& source, LineFaults& faults) {
  Places places;
  for (const BakeJob& job : plan.jobs) places.read(job.input, "the input");
  if (!source.manifest.empty()) places.read(source.manifest, "the manifest");
  if (!source.rules.empty()) places.read(source.rules, "the rules");
  for (const BakeJob& job : plan.jobs)
    if (const auto place = check_output(job, places); !place) faults.add(job.line, place.error().detail);
  for (const BakeJob& job : plan.jobs)
    if (!job.picture.empty())
      if (auto place = places.write(job.picture, "the picture of '" + job.output + "'"); !place) return place;
  if (!plan.html.empty()) {
    if (auto place = places.write(plan.html, "the page"); !place) return place;
    if (!may_be_html_report(plan.html))
      return wrong("'" + plan.html +
                   "' exists and was not written by a bake: move it, or choose another path for --html.");
  }
  if (!plan.report.empty()) {
    if (plan.report == kStandardStream)
      return wrong("--report needs a file, not '-', because the next bake reads it.");
    if (auto place = places.write(plan.report, "the report"); !place) return place;
    if (!BakeReport::may_be(plan.report))
      return wrong("'" + plan.report +
                   "' exists and is not a bake report: move it, or choose another path for --report.");
  }
  if (!source.depfile.empty()) {
    if (source.depfile == kStandardStream || plan.jobs.front().output == kStandardStream ||
        plan.jobs.front().input == kStandardStream)
      return wrong("--depfile needs files: it cannot be used with '-' as input, output or depfile.");
    if (auto place = places.write(source.depfile, "the depfile"); !place) return place;
  }
  if (source.stages.empty()) return {};
  for (const std::string& path : stage_files(source.stages)) {
    std::error_code error;
    if (fs::exists(fs::symlink_status(path, error)))
      return wrong(
          "'" + path +
          "' exists, and --dump-stages does not overwrite files: move it, or choose another folder.");
    if (auto place = places.write(path, "a stage"); !place) return place;
  }
  return {};
}

}  // namespace fracture::bake
