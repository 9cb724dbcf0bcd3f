// Reads the text exposition format of Prometheus (version 0.0.4) strictly: what a test reads here, a scraper
// can read.
#pragma once

#include <map>
#include <string>

namespace fracture::test {

struct Exposition {
  /// "name{a=\"1\",b=\"2\"}" as written, to its value.
  std::map<std::string, double> samples;
  std::map<std::string, std::string> types;

  /// The sample, 0 when there is none.
  double operator[](const std::string& name) const;
  /// Sum of the samples of a family whose labels contain `label`.
  double sum(const std::string& family, const std::string& label = "") const;
};

/// Throws std::runtime_error that names the line: one that is neither comment nor sample, a sample without a
/// TYPE before it, a repeated sample or family.
Exposition parse_exposition(const std::string& text);

}  // namespace fracture::test
