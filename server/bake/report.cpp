#include "server/bake/report.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <set>
#include <utility>

#include "common/base/atomic_file.hpp"
#include "common/base/json_text.hpp"
#include "server/bake/output_files.hpp"
#include "server/bake/output_folders.hpp"
#include "server/bake/output_path.hpp"

namespace fracture::bake {

std::string text_in(const nlohmann::json& object, const char* name) {
  const auto at = object.is_object() ? object.find(name) : object.end();
  return at != object.end() && at->is_string() ? at->get<std::string>() : std::string();
}

bool is_right(const KnownOutput& known, const std::string& output) {
  if (digest_of_file(output) != known.digest) return false;
  const auto beside = known.line.find("beside");
  if (beside == known.line.end()) return materials_beside(output).empty();
  return beside->is_array() && std::all_of(beside->begin(), beside->end(), [](const nlohmann::json& file) {
           const std::string path = text_in(file, "path");
           return !path.empty() && digest_of_file(path) == text_in(file, "digest");
         });
}

BakeReport::BakeReport(std::string path) : path_(std::move(path)) {
  if (path_.empty()) return;
  std::ifstream file(path_);
  bool unfinished = false;  // true if a run was killed while writing a line
  for (std::string line; std::getline(file, line);) {
    unfinished = file.eof();
    nlohmann::json json = json_or_null(line, kOfALine);
    const std::string output = text_in(json, "output");
    if (output.empty()) continue;
    if (text_in(json, "status") != "made") {
      known_.erase(output);  // the latest line says refused or unsound
      continue;
    }
    KnownOutput known{text_in(json, "key"), text_in(json, "digest"), {}};
    known.line = std::move(json);
    known_[output] = std::move(known);
  }
  make_folders_of(path_);
  fd_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (fd_ < 0) trouble_ = errno;
  if (unfinished && fd_ >= 0 && ::write(fd_, "\n", 1) != 1) {
    trouble_ = errno;
    ::close(fd_);
    fd_ = -1;
  }
}

BakeReport::~BakeReport() {
  if (fd_ >= 0) ::close(fd_);
}

bool BakeReport::may_be(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  if (!file || !std::getline(file, line)) return true;
  const auto read = read_json(line, kOfALine);
  if (!read && read.error().kind == JsonFault::Kind::kSyntax)
    return file.eof() && line.starts_with("{\"");  // a run was killed while writing its first line
  return read && read->value.is_object() && read->value.contains("output") && read->value.contains("status");
}

const KnownOutput* BakeReport::find(const std::string& output) const {
  const auto it = known_.find(as_utf8(output));
  return it == known_.end() ? nullptr : &it->second;
}

bool BakeReport::add(std::size_t job, const nlohmann::json& line) {
  std::string text = json_text(line) + "\n";
  const std::lock_guard lock(mutex_);
  bool good = true;
  if (!path_.empty()) {
    const ssize_t written = fd_ < 0 ? -1 : ::write(fd_, text.data(), text.size());
    good = written == static_cast<ssize_t>(text.size());
  }
  lines_[job] = std::move(text);
  return good;
}

bool BakeReport::finish(const std::vector<std::string>& outputs) {
  if (path_.empty()) return true;
  const std::lock_guard lock(mutex_);
  std::string all;
  for (const auto& [job, line] : lines_) all += line;
  std::set<std::string> mine;
  for (const std::string& output : outputs) mine.insert(as_utf8(output));
  for (const auto& [output, known] : known_)
    if (!mine.contains(output)) all += json_text(known.line) + "\n";
  return write_atomically(path_, std::as_bytes(std::span(all)));
}

std::vector<nlohmann::json> BakeReport::lines() const {
  const std::lock_guard lock(mutex_);
  std::vector<nlohmann::json> lines;
  for (const auto& [job, line] : lines_) lines.push_back(json_or_null(line, kOfALine));
  return lines;
}

}  // namespace fracture::bake
