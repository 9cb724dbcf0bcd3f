// The report of a bake, with one JSON object per line. It is also the memory of a bake: its lines decide
// whether the next run must make an output again.
#pragma once

#include <cstddef>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/base/json_reader.hpp"

namespace fracture::bake {

/// Limits for a line. The report may have been replaced by any file, and deeper or larger lines are not ours.
/// Parameters are the largest part of a line.
inline constexpr JsonLimits kOfALine{.depth = 16, .bytes = std::size_t{64} << 20};

/// Returns a text member, or an empty string if `object` has none.
std::string text_in(const nlohmann::json& object, const char* name);

struct KnownOutput {
  std::string key;     ///< RequestKeys::result: covers everything that decides the bytes
  std::string digest;  ///< "sha256:<hex>" of the file
  nlohmann::json line;
};
/// Returns whether the output, and all files written with it, still have the digests given in the line.
bool is_right(const KnownOutput& known, const std::string& output);

/// Lines are appended with a single write whenever a job ends, so that they survive if the run is killed.
/// finish() then puts them in job order. Thread-safe.
class BakeReport {
 public:
  /// Reads the report of earlier runs. An incomplete last line of a killed run is dropped. With an empty
  /// path, nothing is written.
  explicit BakeReport(std::string path);
  ~BakeReport();
  BakeReport(const BakeReport&) = delete;
  BakeReport& operator=(const BakeReport&) = delete;

  /// The errno from opening the file for writing; 0 if it is open or there is no path.
  int trouble() const { return trouble_; }
  /// Returns whether there is no file yet or one that a bake has written. finish() would overwrite any other
  /// file.
  static bool may_be(const std::string& path);
  /// Returns null if no earlier run made this output.
  const KnownOutput* find(const std::string& output) const;
  /// Appends the line of a job. Returns false and sets errno on failure.
  bool add(std::size_t job, const nlohmann::json& line);
  /// Atomically rewrites the file: one line per job in job order, then the lines of outputs that do not
  /// belong to this run (another shard with the same report). Returns false and sets errno on failure.
  bool finish(const std::vector<std::string>& outputs);
  /// The lines of this run so far, in job order.
  std::vector<nlohmann::json> lines() const;

 private:
  std::string path_;
  int fd_ = -1, trouble_ = 0;
  std::map<std::string, KnownOutput> known_;
  mutable std::mutex mutex_;
  std::map<std::size_t, std::string> lines_;
};

}  // namespace fracture::bake
