#include "tests/server/support/record.hpp"

#include <cstdlib>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>

namespace fracture::test {

void record_exchange(const std::string& method, const std::string& target, int status,
                     const std::map<std::string, std::string>& headers, const std::string& body) {
  static const char* const path = std::getenv("FRACTURE_TEST_RECORD");
  if (!path) return;
  static std::mutex mutex;
  static std::ofstream file(path, std::ios::trunc);
  const auto type = headers.find("content-type");
  const bool json =
      body.empty() || (type != headers.end() && type->second.find("json") != std::string::npos &&
                       headers.count("content-encoding") == 0);
  nlohmann::ordered_json line = {
      {"method", method}, {"target", target}, {"status", status}, {"headers", headers}};
  line["body"] = json ? nlohmann::ordered_json(body) : nlohmann::ordered_json();
  const std::lock_guard lock(mutex);
  file << line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) << std::endl;
}

}  // namespace fracture::test
