#include "server/bake/named_files.hpp"

namespace fracture::bake {

void NamedFiles::add(const InputFile& input, const BakeJob& job) {
  const std::lock_guard lock(mutex_);
  for (const SiblingFile& file : input.siblings)
    named_.emplace(identity_of(file.path), "a file that " + job.input + " names");
}

std::optional<Error> NamedFiles::loss_by(const BakeJob& job, const std::string& depfile) const {
  for (const std::string& path : {job.output, materials_beside(job.output), depfile})
    if (!path.empty() && path != kStandardStream)
      if (std::optional<Error> loss = loss_of(path)) {
        if (path != job.output)
          loss->detail = (path == depfile ? "the depfile " : "") + path + ": " + loss->detail;
        return loss;
      }
  return std::nullopt;
}

std::optional<Error> NamedFiles::loss_of(const std::string& path) const {
  const std::lock_guard lock(mutex_);
  const auto at = named_.find(identity_of(path));
  if (at == named_.end()) return std::nullopt;
  return Error{ErrorCode::kFileAccess, "it is " + at->second};
}

}  // namespace fracture::bake
