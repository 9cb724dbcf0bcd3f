#include "server/http/prefer.hpp"

#include <algorithm>
#include <charconv>
#include <string>
#include <string_view>

#include "common/base/text.hpp"

namespace fracture::http {
namespace {

/// Removes the text before the next comma outside quotes from the list and returns it.
std::string_view next_item(std::string_view& list) {
  bool quoted = false;
  std::size_t end = 0;
  for (; end < list.size() && (quoted || list[end] != ','); ++end) {
    if (quoted && list[end] == '\\')
      ++end;
    else if (list[end] == '"')
      quoted = !quoted;
  }
  const std::string_view item = list.substr(0, std::min(end, list.size()));
  list.remove_prefix(std::min(list.size(), end + 1));
  return item;
}

/// Parses delta-seconds, as a token or in quotes.
std::optional<std::chrono::seconds> seconds_of(std::string_view value) {
  value = trimmed(value);
  if (value.size() >= 2 && value.front() == '"' && value.back() == '"')
    value = value.substr(1, value.size() - 2);
  if (value.empty() || !std::all_of(value.begin(), value.end(), [](char c) { return c >= '0' && c <= '9'; }))
    return std::nullopt;
  std::uint64_t seconds = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), seconds);
  const auto longest = static_cast<std::uint64_t>(kLongestWait.count());
  if (error == std::errc::result_out_of_range) seconds = longest;
  return std::chrono::seconds(std::min(seconds, longest));
}

}  // namespace

Preferences preferences_of(const RequestHead& head) {
  Preferences preferences;
  const std::string field = head.field("prefer");
  for (std::string_view rest = field; !rest.empty();) {
    std::string_view item = next_item(rest);
    item = item.substr(0, item.find(';'));
    const std::string_view before = item.substr(0, item.find('=')), name = trimmed(before);
    const bool valued = before.size() < item.size();
    if (equals_ignoring_case(name, "respond-async")) preferences.respond_async = true;
    if (valued && !preferences.wait && equals_ignoring_case(name, "wait"))
      preferences.wait = seconds_of(item.substr(item.find('=') + 1));
  }
  return preferences;
}

std::string applied(const Preferences& preferences) {
  std::string text = preferences.respond_async ? "respond-async" : "";
  if (preferences.wait)
    text += (text.empty() ? "wait=" : ", wait=") + std::to_string(preferences.wait->count());
  return text;
}

}  // namespace fracture::http
