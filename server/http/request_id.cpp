#include "server/http/request_id.hpp"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <random>
#include <string_view>

#include "common/base/random.hpp"

namespace fracture::http {
namespace {

bool is_hex(std::string_view s) {
  return std::all_of(s.begin(), s.end(),
                     [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

bool is_zero(std::string_view s) { return s.find_first_not_of('0') == std::string_view::npos; }

}  // namespace

std::string new_request_id() {
  static std::atomic<std::uint64_t> next{[] {
    std::random_device device;
    return (static_cast<std::uint64_t>(device()) << 32) | device();
  }()};
  constexpr char kDigits[] = "0123456789abcdef";
  std::uint64_t value = Random(next.fetch_add(1))();
  std::string id(16, '0');
  for (char& c : id) {
    c = kDigits[value & 15];
    value >>= 4;
  }
  return id;
}

std::string request_id(const RequestHead& head) {
  const std::string given = head.field("x-request-id");
  const auto harmless = [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-' ||
           c == '_' || c == '.';
  };
  if (given.empty() || given.size() > 64 || !std::all_of(given.begin(), given.end(), harmless))
    return new_request_id();
  return given;
}

TraceContext trace_context(const RequestHead& head) {
  // version "-" trace-id "-" parent-id "-" flags; later versions may append more fields.
  const std::string field = head.field("traceparent");
  const std::string_view text(field);
  if (text.size() < 55 || text[2] != '-' || text[35] != '-' || text[52] != '-') return {};
  const std::string_view version = text.substr(0, 2), trace = text.substr(3, 32),
                         parent = text.substr(36, 16);
  if (!is_hex(version) || version == "ff" || !is_hex(trace) || is_zero(trace) || !is_hex(parent) ||
      is_zero(parent) || !is_hex(text.substr(53, 2)))
    return {};
  if (version == "00" ? text.size() != 55 : text.size() > 55 && text[55] != '-') return {};
  return {std::string(trace), std::string(parent)};
}

}  // namespace fracture::http
