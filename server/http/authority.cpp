#include "server/http/authority.hpp"

#include <algorithm>

namespace fracture::http {

std::optional<Authority> authority_in(std::string_view text) {
  constexpr std::size_t kLongestPort = 5;
  std::size_t end = 0;  // end of the host
  if (!text.empty() && text.front() == '[') {
    end = text.find(']');
    if (end == std::string_view::npos || end == 1) return std::nullopt;
    ++end;
    if (text.substr(1, end - 2).find('[') != std::string_view::npos) return std::nullopt;
  } else {
    end = std::min(text.find(':'), text.size());
    if (end == 0 || text.substr(0, end).find_first_of("[]") != std::string_view::npos) return std::nullopt;
  }
  Authority authority{text.substr(0, end), {}};
  if (end == text.size()) return authority;
  if (text[end] != ':') return std::nullopt;
  authority.port = text.substr(end + 1);
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  if (authority.port.empty() || authority.port.size() > kLongestPort ||
      !std::all_of(authority.port.begin(), authority.port.end(), is_digit))
    return std::nullopt;
  return authority;
}

}  // namespace fracture::http
