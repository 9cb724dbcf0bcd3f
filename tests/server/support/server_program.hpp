// The server program that the tests start: this build, or another build that FRACTURE_TEST_SERVER names. With
// an older build one can show that a test fails there. Settings that the other build does not know are left
// out.
#pragma once

#include <sys/resource.h>
#include <sys/types.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

namespace fracture::test {

inline const char* other_server_program() { return std::getenv("FRACTURE_TEST_SERVER"); }

inline std::string server_program() {
  const char* other = other_server_program();
  return other ? other : FRACTURE_SERVER_PROGRAM;
}

/// Returns those settings, with their values, that the program's --help names.
inline std::vector<std::string> known_settings(const std::vector<std::string>& settings) {
  if (!other_server_program()) return settings;
  static const std::string help = [] {
    FILE* const output = ::popen(("'" + server_program() + "' serve --help").c_str(), "r");
    if (!output) throw std::runtime_error("popen");
    std::string text;
    char part[4096];
    std::size_t length = 0;
    while ((length = std::fread(part, 1, sizeof part, output)) > 0) text.append(part, length);
    ::pclose(output);
    return text;
  }();
  std::vector<std::string> known;
  bool takes = true;
  for (const std::string& word : settings) {
    if (word.starts_with("--")) takes = help.find(word + " ") != std::string::npos;
    if (takes) known.push_back(word);
  }
  return known;
}

/// Returns whether the program's token file can give shares to names; otherwise the file is plain lines.
inline bool knows_shares() { return !known_settings({"--trusted-proxy", "192.0.2.1"}).empty(); }

/// An older build without limits may use all memory of the machine, and other processes would be killed.
inline void protect_the_machine_from(pid_t pid) {
  const rlimit most{std::uint64_t{4} << 30, std::uint64_t{4} << 30};
  if (other_server_program()) ::prlimit(pid, RLIMIT_AS, &most, nullptr);
}

}  // namespace fracture::test
