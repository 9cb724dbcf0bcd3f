// Which program the tests start as the server: ours, or another build of it that FRACTURE_TEST_SERVER names,
// to show that a test fails there. Settings that the other one does not know are left out.
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

/// Of settings, each with its value behind it, those that the program's --help names.
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

/// Whether its names of tokens may have shares; else they are lines.
inline bool knows_shares() { return !known_settings({"--trusted-proxy", "192.0.2.1"}).empty(); }

/// A build without limits may take all the memory of the machine, and others are killed for it.
inline void protect_the_machine_from(pid_t pid) {
  const rlimit most{std::uint64_t{4} << 30, std::uint64_t{4} << 30};
  if (other_server_program()) ::prlimit(pid, RLIMIT_AS, &most, nullptr);
}

}  // namespace fracture::test
