// Reads JSON from untrusted sources: within limits of depth and memory, in linear time, and without repeated
// members. Also computes the memory that a parsed value uses, for budgets.
//
// If an object has several members with the same name, JSON libraries silently keep one of them, so two
// readers may see different values (RFC 8259, section 4). Also, three bytes of text ("{},") can become a
// hundred bytes in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <tl/expected.hpp>

#include "common/base/execution.hpp"

namespace fracture {

struct JsonLimits {
  std::uint32_t depth = 8;        ///< nesting of arrays and objects
  std::size_t bytes = 16u << 20;  ///< maximum memory of the value (json_bytes)
};

struct JsonFault {
  enum class Kind {
    kSyntax,    ///< not JSON
    kTooDeep,   ///< exceeds JsonLimits::depth
    kTooLarge,  ///< exceeds JsonLimits::bytes
    kRepeated,  ///< a member is given twice: `name`
  };
  Kind kind = Kind::kSyntax;
  std::string name{};    ///< name of the repeated member, at most 100 bytes of it
  std::size_t byte = 0;  ///< number of bytes read
  bool at_end = false;   ///< kSyntax: the text ends before the JSON is complete
};
/// Returns the rest of a sentence whose subject is the text, e.g. "names 'a' more than once".
std::string to_text(const JsonFault& fault);

struct JsonDocument {
  nlohmann::json value;
  std::vector<std::string> members;  ///< members of the outermost object, in the order of the text
};
/// Parses the text and stops at the first fault. Holds no more than `limits.bytes` (and the text of one
/// string) at any time. Polls once per some hundred values. Throws Interrupted.
tl::expected<JsonDocument, JsonFault> read_json(std::string_view text, const JsonLimits& limits,
                                                const Execution& execution = kUninterrupted);

/// Returns only the value; null if read_json() refuses the text.
inline nlohmann::json json_or_null(std::string_view text, const JsonLimits& limits = {}) {
  auto read = read_json(text, limits);
  return read ? std::move(read->value) : nlohmann::json();
}

/// Heap bytes behind the value, as glibc's malloc allocates them (measured: tests/base/json_reader_test.cpp).
/// The size classes of jemalloc are up to a quarter coarser. This is within the 1.3 bytes that a server
/// reserves for each counted byte.
std::size_t json_bytes(const nlohmann::json& value);

}  // namespace fracture
