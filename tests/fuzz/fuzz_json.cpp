// Fuzz target: the reader for untrusted JSON, compared with the library's own. If it accepts a text, the
// value is the same and within its limits. If it reports a syntax error, the library refuses the text as
// well.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "common/base/json_reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fracture;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const JsonLimits limits{.depth = 6, .bytes = 16u << 10};
  const auto read = read_json(text, limits);
  const nlohmann::json whole = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (read && (read->value != whole || json_bytes(read->value) > limits.bytes)) std::abort();
  if (!read && read.error().kind == JsonFault::Kind::kSyntax && !whole.is_discarded()) std::abort();
  if (!read && to_text(read.error()).empty()) std::abort();
  return 0;
}
