#include "common/base/words.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iterator>

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

std::string data_size(std::uint64_t bytes) {
  if (bytes < 1000) return counted(bytes, "byte", "bytes");
  constexpr const char* kUnits[] = {"kB", "MB", "GB", "TB"};
  std::size_t unit = 0;
  double number = static_cast<double>(bytes) / 1000;
  for (; number >= 999.95 && unit + 1 < std::size(kUnits); ++unit) number /= 1000;
  return short_number(number) + " " + kUnits[unit];
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
