// Fuzz target: the first byte chooses between a query and a JSON object of parameters. Accepted parameters
// have a canonical form that means the same.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string_view>

#include "common/parameters/parameters.hpp"
#include "server/http/request_head.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fracture;
  static const ParameterTable table(100'000, FormatSet::all());
  if (size < 1) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  std::vector<RawParameter> given;
  if (data[0] == '?') {
    const auto query = http::parse_query(text);
    if (!query) return 0;
    for (const auto& [name, value] : *query) given.push_back({name, value, true});
  } else {
    const auto document = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
    if (!document.is_object()) return 0;
    for (const auto& [name, value] : document.items()) given.push_back({name, value, false});
  }
  const auto parsed = table.parse(given);
  if (!parsed) {
    if (parsed.error().detail.empty()) std::abort();
    return 0;
  }
  const nlohmann::json canonical = canonical_parameters(*parsed);
  std::vector<RawParameter> again;
  for (const auto& [name, value] : canonical.items())
    if (table.find(name) && !value.is_null()) again.push_back({name, value, false});
  const auto reparsed = table.parse(again);
  if (!reparsed || canonical_parameters(*reparsed) != canonical) std::abort();
  return 0;
}
