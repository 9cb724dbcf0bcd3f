#include "server/bake/form.hpp"

#include <algorithm>

namespace fracture::bake {
namespace {

/// Returns a quoted-string (RFC 9110, section 5.6.4).
std::string quoted_string(const std::string& text) {
  std::string result(1, '"');
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  result += '"';
  return result;
}

bool has_control_character(const std::string& text) {
  return std::any_of(text.begin(), text.end(),
                     [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
}

}  // namespace

Expected<Form> write_form(std::span<const FormPart> parts) {
  std::size_t size = 0;
  for (const FormPart& part : parts) {
    if (has_control_character(part.filename))
      return fail(
          ErrorCode::kExternalResource,
          "The name of a file that the mesh references contains a control character, so the file cannot "
          "be sent: rename the file.");
    size += part.body.size() + part.filename.size() + 200;
  }
  std::string boundary = "fracture-bake";
  for (int k = 0;
       std::any_of(parts.begin(), parts.end(),
                   [&](const FormPart& part) { return part.body.find(boundary) != std::string_view::npos; });
       ++k)
    boundary += std::to_string(k);
  Form form{"multipart/form-data; boundary=" + boundary, {}};
  form.body.reserve(size);
  for (const FormPart& part : parts) {
    form.body.append("--").append(boundary).append("\r\nContent-Disposition: form-data; name=");
    form.body.append(quoted_string(part.name));
    if (!part.filename.empty()) form.body.append("; filename=").append(quoted_string(part.filename));
    form.body.append("\r\n\r\n").append(part.body).append("\r\n");
  }
  form.body.append("--").append(boundary).append("--\r\n");
  return form;
}

}  // namespace fracture::bake
