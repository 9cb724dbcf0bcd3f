// Records the requests of a test and the answers, one JSON object per line, if the environment names a file
// for it. tests/contract validates the lines against the interface document.
#pragma once

#include <map>
#include <string>

namespace fracture::test {

/// Thread-safe. A body that is not JSON, or that is compressed, is recorded as null.
void record_exchange(const std::string& method, const std::string& target, int status,
                     const std::map<std::string, std::string>& headers, const std::string& body);

}  // namespace fracture::test
