// The help: headings, values and defaults of options, wrapped to the width of the terminal.
#pragma once

#include <memory>
#include <string>

#include "common/parameters/spec.hpp"

namespace CLI {
class FormatterBase;
}

namespace fracture::cli {

/// Formatter for help. If a name has two spellings, it shows only the one with dashes. Values and default come before the description:
/// "[0 to 1024; default 0]".
std::shared_ptr<CLI::FormatterBase> help_formatter();

/// Returns the placeholder for a parameter's value: "N", "X,Y,Z", "fill|strict".
std::string placeholder_of(const ParameterSpec& spec);

/// Returns a parameter's values, default and patterns: "[a number from 0 to 0.9; default 0.4; only with radial]".
std::string values_of(const ParameterSpec& spec);

}  // namespace fracture::cli
