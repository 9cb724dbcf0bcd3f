// Reads the usual numbers of an OBJ in one pass, without finding each word first.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/import/text_words.hpp"

namespace fracture {

/// Whether the digit at `at` continues a number; `digit` is its value.
inline bool is_digit(const char* at, const char* end, unsigned& digit) {
  if (at == end) return false;
  digit = static_cast<unsigned>(static_cast<unsigned char>(*at)) - unsigned{'0'};
  return digit <= 9;
}

/// Reads a whole number of at most nine digits and goes past it. Returns false, without moving, for any other text.
inline bool scan_index(const char*& at, const char* end, std::int64_t& number) {
  constexpr int kDigits = 9;
  const char* next = at;
  std::uint32_t value = 0;
  for (unsigned digit = 0; is_digit(next, end, digit); ++next) {
    if (next - at == kDigits) return false;
    value = 10 * value + digit;
  }
  if (next == at) return false;
  at = next;
  number = value;
  return true;
}

/// Reads a decimal number such as -12.345 that ends at a blank or at the end, and goes past it. Returns false, without moving,
/// for any other text. The result is the nearest double, because one division of two exact doubles is rounded correctly:
/// integers up to 2^53, and powers of ten up to 10^22 (Clinger 1990, "How to read floating point numbers accurately").
inline bool scan_number(const char*& at, const char* end, double& number) {
  constexpr int kDigits = 18;  // of which 64 bits can hold any
  static constexpr double kPowers[kDigits + 1] = {1,    1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8, 1e9,
                                                  1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18};
  const bool negative = at != end && *at == '-';
  const char* next = at + (negative ? 1 : 0);
  const char* const begin = next;
  std::uint64_t value = 0;
  unsigned digit = 0;
  for (; is_digit(next, end, digit); ++next) value = 10 * value + digit;
  auto digits = next - begin;
  std::ptrdiff_t decimals = 0;
  if (next != end && *next == '.') {
    const char* const point = ++next;
    for (; is_digit(next, end, digit); ++next) value = 10 * value + digit;
    decimals = next - point;
    digits += decimals;
  }
  if (digits == 0 || digits > kDigits || value > std::uint64_t{1} << 53) return false;
  if (next != end && !blank_in_line(*next)) return false;
  const double magnitude = static_cast<double>(value) / kPowers[decimals];
  number = negative ? -magnitude : magnitude;
  at = next;
  return true;
}

}  // namespace fracture
