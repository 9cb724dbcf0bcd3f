// Collects everything that is wrong with the jobs of a bake, so that all faults are reported at once.
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

  /// `detail`: a sentence. `line`: line of the manifest, starting at 1, or 0 if the fault belongs to no line.
  void add(std::size_t line, std::string detail) { faults_.emplace_back(line, std::move(detail)); }
  bool empty() const { return faults_.empty(); }
  /// Returns kBadParameter. Its detail has one line of text per fault, in manifest order. Lines with the same
  /// fault are grouped: "Lines 2, 4 to 9 of 'night.ndjson': …". After kMostFaults different faults, only the
  /// number of further ones is given.
  Error error() const;

  static constexpr std::size_t kMostFaults = 1000;

 private:
  std::string manifest_;
  std::vector<std::pair<std::size_t, std::string>> faults_;
};

}  // namespace fracture::bake
