// multipart/form-data (RFC 7578), written.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "common/base/error.hpp"

namespace fracture::bake {

struct FormPart {
  std::string name;
  std::string filename{};  ///< empty: none
  std::string_view body;
};

struct Form {
  std::string content_type;  ///< with the boundary, which occurs in no part
  std::string body;
};

/// kExternalResource for a file name with a control character, which no header field can hold.
Expected<Form> write_form(std::span<const FormPart> parts);

}  // namespace fracture::bake
