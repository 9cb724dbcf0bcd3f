#include "server/http/accept.hpp"

#include <algorithm>

#include "common/base/text.hpp"
#include "server/http/request_head.hpp"

namespace fracture::http {
namespace {

/// Offer of a route that serves files whose type depends on their name. Every range of the client matches it.
constexpr std::string_view kAnyType = "*/*";

/// Returns 2 for the type itself, 1 for type/*, 0 for */* and -1 for no match.
int specificity(std::string_view range, std::string_view offer) {
  if (equals_ignoring_case(range, offer)) return 2;
  if (range == "*/*") return 0;
  const std::size_t slash = offer.find('/');
  return range.size() == slash + 2 && range.substr(slash) == "/*" &&
                 equals_ignoring_case(range.substr(0, slash), offer.substr(0, slash))
             ? 1
             : -1;
}

}  // namespace

int thousandths(std::string_view q) {
  if (q.empty() || q.size() > 5 || (q[0] != '0' && q[0] != '1') || (q.size() > 1 && q[1] != '.')) return -1;
  int value = (q[0] - '0') * 1000, scale = 100;
  for (std::size_t i = 2; i < q.size(); ++i, scale /= 10) {
    if (q[i] < '0' || q[i] > '9') return -1;
    value += (q[i] - '0') * scale;
  }
  return value > 1000 ? -1 : value;
}

std::optional<std::size_t> negotiate(std::string_view accept, std::span<const std::string_view> offers) {
  if (trimmed(accept).empty()) return 0;
  std::optional<std::size_t> best;
  int best_quality = 0;
  for (std::size_t k = 0; k < offers.size(); ++k) {
    int quality = 0, matched = -1;
    for (std::string_view rest = accept; !rest.empty();) {
      const std::string_view item = rest.substr(0, rest.find(','));
      rest.remove_prefix(std::min(rest.size(), item.size() + 1));
      int q = 1000;
      for (std::size_t semicolon = item.find(';'); semicolon != std::string_view::npos;) {
        const std::size_t next = item.find(';', semicolon + 1);
        const std::string_view parameter = trimmed(item.substr(semicolon + 1, next - semicolon - 1));
        if (parameter.size() > 2 && (parameter[0] == 'q' || parameter[0] == 'Q') && parameter[1] == '=')
          q = thousandths(parameter.substr(2));
        semicolon = next;
      }
      const std::string_view range = trimmed(item.substr(0, item.find(';')));
      const bool any = offers[k] == kAnyType && range.find('/') != std::string_view::npos;
      const int s = any ? 0 : specificity(range, offers[k]);
      if (q < 0 || (any ? q <= quality : s <= matched)) continue;
      matched = s;
      quality = q;
    }
    if (matched >= 0 && quality > best_quality) {
      best = k;
      best_quality = quality;
    }
  }
  return best;
}

}  // namespace fracture::http
