#pragma once

#include <string>

namespace fracture {

/// Shortest decimal text that reads back as the same double, as everywhere in a result.
std::string text_of(double value);

}  // namespace fracture
