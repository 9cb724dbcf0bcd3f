#include "server/http/parameter_weight.hpp"

#include <algorithm>
#include <string>

#include "server/http/limits.hpp"

namespace fracture::http {
namespace {

/// Returns how many entries `assign` has. In an entry that is not text, each parameter counts too.
std::uint64_t rows_of_assign(const nlohmann::json& value) {
  if (value.is_string()) {  // selector:material;selector:material, or JSON
    const std::string& text = value.get_ref<const std::string&>();
    return 1 + static_cast<std::uint64_t>(
                   std::count_if(text.begin(), text.end(), [](char c) { return c == ';' || c == '{'; }));
  }
  std::uint64_t rows = value.size();
  for (const nlohmann::json& entry : value)
    if (entry.size() > 2) rows += entry.size() - 2;  // a selector and a material
  return rows;
}

}  // namespace

std::uint64_t parse_weight(std::uint64_t bytes, const std::vector<RawParameter>& given,
                           const ParameterTable& table) {
  std::uint64_t rows = 0;
  for (const RawParameter& raw : given) {
    if (raw.name == "assign")
      rows += rows_of_assign(raw.value);
    else if (raw.name != "mesh" && !table.find(raw.name))
      ++rows;
    if (bytes + kBytesOfRow * rows > kParseInline) break;  // that is enough to know
  }
  return bytes + kBytesOfRow * rows;
}

}  // namespace fracture::http
