// Writes multipart/form-data (RFC 7578).
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "common/base/error.hpp"

namespace fracture::bake {

struct FormPart {
  std::string name;
  std::string filename{};  ///< empty: no file name
  std::string_view body;
};

struct Form {
  std::string content_type;  ///< includes the boundary, which occurs in no part
  std::string body;
};

/// Returns kExternalResource if a file name contains a control character, which header fields do not allow.
Expected<Form> write_form(std::span<const FormPart> parts);

}  // namespace fracture::bake
