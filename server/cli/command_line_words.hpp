// Messages about wrong options, in place of those of the library that parses the command line.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>

namespace fracture::cli {

/// Validator: a whole number in this range. Its description in the help is that of CLI::Range.
CLI::Validator in_range(std::uint64_t low, std::uint64_t high);

/// For CLI::App::failure_message(): what is wrong with the command line, and where the help is.
std::string words_of_failure(const CLI::App* app, const CLI::Error& error);

}  // namespace fracture::cli
