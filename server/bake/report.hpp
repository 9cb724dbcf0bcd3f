// The report of a bake, one JSON object a line, and its memory: what it says of an output decides whether the
// next run has to make it again.
#pragma once

#include <cstddef>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/base/json_reader.hpp"

namespace fracture::bake {

/// A report may be anybody's file by now: deeper or larger lines are none of ours. Parameters are most of a line.
inline constexpr JsonLimits kOfALine{.depth = 16, .bytes = std::size_t{64} << 20};

/// A member that is text; empty for anything else, whatever `object` is.
std::string text_in(const nlohmann::json& object, const char* name);

struct KnownOutput {
  std::string key;     ///< RequestKeys::result: all that decides the bytes
  std::string digest;  ///< "sha256:<hex>" of the file
  nlohmann::json line;
};
/// Are the bytes that the line says in the output, and in whatever was written beside it?
bool is_right(const KnownOutput& known, const std::string& output);

/// Lines are appended while jobs end, each in one write, so that what a killed run has done is known;
/// finish() puts them in the order of the jobs. Thread-safe.
class BakeReport {
 public:
  /// Reads what earlier runs left; an incomplete last line (a run was killed) is dropped. No path: nothing is
  /// written.
  explicit BakeReport(std::string path);
  ~BakeReport();
  BakeReport(const BakeReport&) = delete;
  BakeReport& operator=(const BakeReport&) = delete;

  /// The errno with which the file could not be opened for writing; 0: it is open, or there is no path.
  int trouble() const { return trouble_; }
  /// Is there nothing yet, or what a bake has left? Anything else would be lost by finish().
  static bool may_be(const std::string& path);
  /// Null where no earlier run made it.
  const KnownOutput* find(const std::string& output) const;
  /// False with errno set.
  bool add(std::size_t job, const nlohmann::json& line);
  /// One line for each job in their order, atomically, and the lines of outputs that are none of this run's
  /// behind them (another shard with the same report). False with errno set.
  bool finish(const std::vector<std::string>& outputs);
  /// Those of this run so far, in the order of the jobs.
  std::vector<nlohmann::json> lines() const;

 private:
  std::string path_;
  int fd_ = -1, trouble_ = 0;
  std::map<std::string, KnownOutput> known_;
  mutable std::mutex mutex_;
  std::map<std::size_t, std::string> lines_;
};

}  // namespace fracture::bake
