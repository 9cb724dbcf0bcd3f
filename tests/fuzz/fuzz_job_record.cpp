// Fuzz target: the contents of a folder of jobs. The first byte chooses between a mesh with its files and the
// JSON of a record, which gets a correct checksum. If a record is accepted, writing it gives a record that
// can be read again, and its numbers are in the ranges that the server computes with.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "common/digest/digest.hpp"
#include "common/parameters/parameters.hpp"
#include "server/jobs/job_record.hpp"

namespace {

void require(bool promise) {
  if (!promise) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fracture;
  if (size < 1) return 0;
  if (data[0] == 'm') {
    auto bytes = std::make_shared<const std::vector<std::uint8_t>>(data, data + size);
    require(!decode_mesh(bytes, 1, std::string(64, '0')));  // no input has this digest
    return 0;
  }
  const std::string text(reinterpret_cast<const char*>(data) + 1, size - 1);
  const auto record = decode_record("fracture job 1\n" + sha256(text).hex() + "\n" + text);
  if (!record) return 0;
  require(is_job_id(record->id) && record->digest.size() == 64 && record->result_key.size() == 64);
  constexpr auto kLast = std::chrono::sys_days(std::chrono::year(10'000) / 1 / 1);
  for (const auto time : {record->created, record->finished_at.value_or(record->created)})
    require(time.time_since_epoch().count() >= 0 && time < kLast);
  require(record->patience.count() > 0 && record->patience <= std::chrono::hours(24));
  require(record->client.size() <= 1024);
  require(record->mesh_bytes <= std::uint64_t{1} << 40);
  const nlohmann::json copy = record->parameters;  // recurses, so the depth must be limited
  std::vector<RawParameter> given;
  for (const auto& [name, value] : copy.items()) given.push_back({name, value, false});
  static const ParameterTable table(10'000'000, FormatSet::all());
  require(table.parse(given).has_value());
  const std::string again = encode_record(*record);
  const auto reread = decode_record(again);
  require(reread && encode_record(*reread) == again);
  return 0;
}
