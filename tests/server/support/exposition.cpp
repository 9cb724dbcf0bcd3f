#include "tests/server/support/exposition.hpp"

#include <cstdlib>
#include <set>
#include <sstream>
#include <stdexcept>

namespace fracture::test {

double Exposition::operator[](const std::string& name) const {
  const auto at = samples.find(name);
  return at == samples.end() ? 0 : at->second;
}

double Exposition::sum(const std::string& family, const std::string& label) const {
  double total = 0;
  for (const auto& [name, value] : samples)
    if ((name == family || name.rfind(family + "{", 0) == 0) && name.find(label) != std::string::npos)
      total += value;
  return total;
}

Exposition parse_exposition(const std::string& text) {
  Exposition result;
  std::set<std::string> helped;
  std::istringstream lines(text);
  std::string line;
  const auto fail = [&line](const char* what) { throw std::runtime_error(std::string(what) + ": " + line); };
  if (text.empty() || text.back() != '\n') throw std::runtime_error("the last line has no end");
  while (std::getline(lines, line)) {
    if (line.empty()) continue;
    std::istringstream words(line);
    std::string first, kind, name, rest;
    if (line[0] == '#') {
      words >> first >> kind >> name >> rest;
      if (kind == "HELP" && !helped.insert(name).second) fail("HELP twice");
      if (kind == "TYPE" && !result.types.emplace(name, rest).second) fail("TYPE twice");
      continue;
    }
    const std::size_t space = line.rfind(' ');
    if (space == std::string::npos) fail("no value");
    name = line.substr(0, space);
    char* end = nullptr;
    const double value = std::strtod(line.c_str() + space + 1, &end);
    if (*end != '\0') fail("the value is no number");
    std::string family = name.substr(0, name.find('{'));
    if (name.find('{') != std::string::npos && name.back() != '}') fail("labels without an end");
    if (family.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_:") !=
        std::string::npos)
      fail("bad name");
    for (const char* suffix : {"_bucket", "_sum", "_count"}) {
      const std::string s(suffix);
      if (!result.types.count(family) && family.size() > s.size() &&
          family.compare(family.size() - s.size(), s.size(), s) == 0 &&
          result.types.count(family.substr(0, family.size() - s.size())))
        family.resize(family.size() - s.size());
    }
    if (!result.types.count(family)) fail("no TYPE before the sample");
    if (!result.samples.emplace(name, value).second) fail("the sample stands twice");
  }
  return result;
}

}  // namespace fracture::test
