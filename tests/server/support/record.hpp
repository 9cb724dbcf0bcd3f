// Writes down what a test asked and what came back, one JSON object a line, where the environment names a
// file for it: tests/contract validates the lines against the interface document.
#pragma once

#include <map>
#include <string>

namespace fracture::test {

/// Thread-safe. Bodies that are no JSON, or JSON that is compressed, are left out (null).
void record_exchange(const std::string& method, const std::string& target, int status,
                     const std::map<std::string, std::string>& headers, const std::string& body);

}  // namespace fracture::test
