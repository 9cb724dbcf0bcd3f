// All that is wrong with the jobs of a bake, so that it is said at once and not one fault a try.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "common/base/error.hpp"

namespace fracture::bake {

class LineFaults {
 public:
  explicit LineFaults(std::string manifest) : manifest_(std::move(manifest)) {}

  /// `detail`: a sentence. `line`: of the manifest, from 1; 0: the fault belongs to no line.
  void add(std::size_t line, std::string detail) { faults_.emplace_back(line, std::move(detail)); }
  bool empty() const { return faults_.empty(); }
  /// kBadParameter. Its detail has a line of text for each fault, in the order of the manifest. Lines with the same fault stand
  /// together: "Lines 2, 4 to 9 of 'night.ndjson': …". Of more than kMostFaults different ones the rest is counted.
  Error error() const;

  static constexpr std::size_t kMostFaults = 1000;

 private:
  std::string manifest_;
  std::vector<std::pair<std::size_t, std::string>> faults_;
};

}  // namespace fracture::bake
