// JSON from strangers: read within limits of depth and memory, in linear time, with every member named once.
// And what a parsed JSON value holds, for budgets.
//
// A JSON library keeps one of several members of the same name without a word, so that two readers of one
// text may take different values (RFC 8259, section 4); and three bytes of text ("{},") become a hundred in
// memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <tl/expected.hpp>

namespace fracture {

struct JsonLimits {
  std::uint32_t depth = 8;        ///< arrays and objects within one another
  std::size_t bytes = 16u << 20;  ///< of memory that the value may hold (json_bytes)
};

struct JsonFault {
  enum class Kind {
    kSyntax,    ///< no JSON
    kTooDeep,   ///< over JsonLimits::depth
    kTooLarge,  ///< over JsonLimits::bytes
    kRepeated,  ///< a member was given twice: `name`
  };
  Kind kind = Kind::kSyntax;
  std::string name{};    ///< of the repeated member, at most 100 bytes of it
  std::size_t byte = 0;  ///< how far the text was read
};
/// "names 'a' more than once", to be completed by what the text was.
std::string to_text(const JsonFault& fault);

struct JsonDocument {
  nlohmann::json value;
  std::vector<std::string> members;  ///< of the outermost object, in the order of the text
};
/// Reading ends at the first fault: no more than `limits.bytes` (and the text of one string) is held at any
/// time.
tl::expected<JsonDocument, JsonFault> read_json(std::string_view text, const JsonLimits& limits);

/// The value alone; null for a text that read_json() refuses.
inline nlohmann::json json_or_null(std::string_view text, const JsonLimits& limits = {}) {
  auto read = read_json(text, limits);
  return read ? std::move(read->value) : nlohmann::json();
}

/// Heap bytes behind the value, as glibc's malloc gives them out (measured: tests/base/json_reader_test.cpp). jemalloc's steps
/// are up to a quarter coarser, which is within the 1.3 bytes that a server sets aside for each that it counts.
std::size_t json_bytes(const nlohmann::json& value);

}  // namespace fracture
