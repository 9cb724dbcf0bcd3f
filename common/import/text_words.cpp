#include "common/import/text_words.hpp"

#include <limits>

#include "common/base/printable.hpp"
#include "common/import/text_encoding.hpp"

namespace fracture {

std::optional<double> unusual_number(std::string_view word) {
  const bool negative = word.starts_with('-');
  std::string_view body = word.substr(negative || word.starts_with('+') ? 1 : 0);
  std::string small(body.substr(0, 3));
  for (char& c : small) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  if (small == "nan" || small == "1.#") return std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double value = 0;
  const auto [at, error] = std::from_chars(body.data(), body.data() + body.size(), value);
  if (error != std::errc::result_out_of_range || at != body.data() + body.size()) return std::nullopt;
  const std::size_t exponent = body.find_first_of("eE");
  const std::string_view power = exponent == std::string_view::npos ? "" : body.substr(exponent + 1);
  const bool tiny = power.empty() ? body.front() == '0' || body.front() == '.' : power.front() == '-';
  value = tiny ? 0 : kInfinity;
  return negative ? -value : value;
}

std::string quotation(std::string_view text) {
  return "\"" + name_as_utf8(printable(shortened(text))) + "\"";
}

}  // namespace fracture
