// The words of `inspect` for many meshes: a line for each, and a summary by cause at the end.
#pragma once

#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace fracture::cli {

// A report here is the document of mesh_report() with the members `input` (path) and `size` (m, of the solid's box). If the
// mesh is refused, it has the members input, verdict ("refused"), error and detail. If the file cannot be read, it has input,
// verdict ("unreadable") and detail.

/// Counts, by kind, the things in the source that the answer will lack: {"light", 2}, {"thin piece without volume", 1}.
std::vector<std::pair<std::string, std::size_t>> losses_in(const nlohmann::json& report);

/// Returns one line: "props/tub.off: repaired; 1 x 1 x 1 m; 1 part; no overlaps; drops nothing; 1 warning". Control
/// characters of names are escaped.
std::string line_of(const nlohmann::json& report);

/// Counts files by verdict, and by the causes of refusals, repairs, losses, overlaps, warnings and choices.
class InspectSummary {
 public:
  /// `exit_code`: what `inspect` returns for this file alone.
  void add(const nlohmann::json& report, int exit_code);
  /// Adds a link without a target, which cannot be read.
  void add_dangling(const std::string& link);

  /// Lines for people. Each cause has a line with at most three of its files.
  std::vector<std::string> lines() const;
  /// Returns {files, closed, repaired, refused, unreadable, causes [{kind, cause, count, inputs}]}. Causes are in the
  /// order of kinds, and within a kind by count, highest first.
  nlohmann::json document() const;
  /// Returns the exit code of the worst file: unreadable, then internal errors, refused, repaired, done.
  int exit_code() const;

 private:
  struct Cause {
    std::string kind, name;
    std::vector<std::string> inputs;
  };
  void cause(std::size_t kind, const std::string& name, const std::string& input);
  std::vector<Cause> sorted() const;

  std::map<std::string, std::size_t> verdicts_;
  std::map<std::pair<std::size_t, std::string>, std::vector<std::string>> causes_;
  std::size_t files_ = 0, worst_ = 0;
};

}  // namespace fracture::cli
