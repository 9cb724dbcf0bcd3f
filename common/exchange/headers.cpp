#include "common/exchange/headers.hpp"

#include <charconv>
#include <cmath>
#include <cstdint>

#include "common/base/text.hpp"
#include "common/digest/digest.hpp"

namespace fracture::protocol {
namespace {

/// Returns the part before the separator; `rest` becomes the part after it.
std::string_view cut(std::string_view& rest, char separator) {
  const std::size_t at = rest.find(separator);
  const std::string_view head = rest.substr(0, at);
  rest = at == std::string_view::npos ? std::string_view() : rest.substr(at + 1);
  return trimmed(head);
}

}  // namespace

std::vector<StageTime> parse_server_timing(std::string_view value) {
  std::vector<StageTime> stages;
  while (!value.empty()) {
    std::string_view entry = cut(value, ',');
    StageTime stage{std::string(cut(entry, ';')), -1};
    while (!entry.empty()) {
      const std::string_view parameter = cut(entry, ';');
      if (!parameter.starts_with("dur=")) continue;
      double duration = 0;
      const char* const end = parameter.data() + parameter.size();
      const auto read = std::from_chars(parameter.data() + 4, end, duration);
      if (read.ec == std::errc() && read.ptr == end && std::isfinite(duration)) stage.milliseconds = duration;
    }
    if (!stage.name.empty() && stage.milliseconds >= 0) stages.push_back(std::move(stage));
  }
  return stages;
}

std::optional<Milliseconds> parse_retry_after(std::string_view value) {
  value = trimmed(value);
  constexpr std::uint32_t kDay = 86'400;
  std::uint32_t seconds = 0;
  const auto read = std::from_chars(value.data(), value.data() + value.size(), seconds);
  if (read.ec != std::errc() || read.ptr != value.data() + value.size() || seconds > kDay)
    return std::nullopt;
  return Milliseconds(1000 * static_cast<std::int64_t>(seconds));
}

bool digest_matches(std::string_view repr_digest, std::string_view bytes) {
  while (!repr_digest.empty()) {
    const std::string_view entry = cut(repr_digest, ',');
    if (entry.starts_with("sha-256="))
      return entry.substr(8) == std::string(":").append(base64(sha256(bytes).bytes)) + ":";
  }
  return false;
}

}  // namespace fracture::protocol
