// Numbers in sentences for people. Programs read the numbers in a report instead.
#pragma once

#include <cstdint>
#include <string>

namespace fracture {

/// Returns the count followed by `one` or `many`: "1 part was", "4,210 parts were".
std::string counted(std::uint64_t count, const char* one, const char* many);

/// Groups digits: "999", "4,210", "1,000,000".
std::string grouped(std::uint64_t number);

/// Writes a number of bytes in powers of a thousand: "1 byte", "999 bytes", "36.7 kB", "67.11 MB", "1.879 GB".
std::string data_size(std::uint64_t bytes);

/// Writes four significant digits, without trailing zeros: "0.0013", "2.5", "12,350", "1.2e-07". Magnitudes
/// below 0.0001, and those of a billion or more, have an exponent. Not finite: "inf", "-inf", "nan".
std::string short_number(double value);

}  // namespace fracture
