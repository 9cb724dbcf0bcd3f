// Numbers in sentences for people. Programs read the figures of a report instead.
#pragma once

#include <cstdint>
#include <string>

namespace fracture {

/// "1 part was", "4,210 parts were": the count, and `one` or `many` after it.
std::string counted(std::uint64_t count, const char* one, const char* many);

/// "999", "4,210", "1,000,000".
std::string grouped(std::uint64_t number);

/// To four significant digits, without zeros at the end: "0.0013", "2.5", "12,350", "1.2e-07". An exponent is there only for
/// magnitudes below 0.0001 and from a billion on. Not finite: "inf", "-inf", "nan".
std::string short_number(double value);

}  // namespace fracture
