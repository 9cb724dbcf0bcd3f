// A strict reader of the Prometheus text exposition format (version 0.0.4): a scraper can read every text
// that this reader accepts.
#pragma once

#include <map>
#include <string>

namespace fracture::test {

struct Exposition {
  /// From a sample's name and labels as written, such as "name{a=\"1\",b=\"2\"}", to its value.
  std::map<std::string, double> samples;
  std::map<std::string, std::string> types;

  /// The sample, or 0 if there is none.
  double operator[](const std::string& name) const;
  /// Sum of a family's samples whose labels contain `label`.
  double sum(const std::string& family, const std::string& label = "") const;
};

/// Throws std::runtime_error that names the line if a line is neither comment nor sample, if a sample has no
/// TYPE before it, or if a sample or family is repeated.
Exposition parse_exposition(const std::string& text);

}  // namespace fracture::test
