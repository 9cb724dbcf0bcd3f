#include "server/bake/files_to_make.hpp"

#include <filesystem>
#include <system_error>

#include "server/bake/stage_dump.hpp"

namespace fracture::bake {

std::vector<std::string> files_to_make(const BakePlan& plan, const RunOptions& options,
                                       const std::function<bool(const BakeJob&)>& known) {
  namespace fs = std::filesystem;
  std::vector<std::string> files{plan.html, options.depfile};
  if (options.failures && options.failures->any())
    files.push_back((fs::path(options.failures->folder()) / "request.json").string());
  const bool draws = options.previews && options.no_pictures.empty();
  if (!options.stages.empty()) files.push_back(stage_files(options.stages).front());
  for (const BakeJob& job : plan.jobs) {
    const bool may_be_kept = !options.force && known(job);
    if (!may_be_kept) files.push_back(job.output);
    std::error_code error;
    if (draws && !(may_be_kept && fs::exists(job.picture, error))) files.push_back(job.picture);
  }
  return files;
}

}  // namespace fracture::bake
