#include "common/base/words.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace fracture {
namespace {

constexpr double kLeast = 1e-4, kMost = 1e9;  // range of magnitudes that are written without an exponent

}  // namespace

std::string grouped(std::uint64_t number) {
  std::string text = std::to_string(number);
  for (std::size_t at = text.size(); at > 3;) text.insert(at -= 3, ",");
  return text;
}

std::string counted(std::uint64_t count, const char* one, const char* many) {
  return grouped(count) + " " + (count == 1 ? one : many);
}

std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  const double near = std::strtod(text, nullptr), size = std::fabs(near);
  if (!(size >= kLeast && size < kMost)) return near == 0 ? "0" : text;
  if (size < 10'000) return text;
  return (near < 0 ? "-" : "") + grouped(static_cast<std::uint64_t>(size));
}

}  // namespace fracture
