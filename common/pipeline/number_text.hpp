#pragma once

#include <string>

namespace fracture {

/// As everything else that an answer says: the shortest that reads back as the same double.
std::string text_of(double value);

}  // namespace fracture
