// Fuzz target: the first line is a Content-Type, the rest a form.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "server/http/multipart.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fracture::http;
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  const std::size_t line = input.find('\n');
  if (line == std::string_view::npos) return 0;
  const auto boundary = multipart_boundary(input.substr(0, line));
  if (!boundary) return 0;
  if (boundary->empty() || boundary->size() > 70) std::abort();
  const std::string_view body = input.substr(line + 1);
  const auto parts = parse_multipart(body, *boundary);
  if (!parts) {
    if (parts.error().detail.empty()) std::abort();
    return 0;
  }
  if (parts->size() > kMaxParts) std::abort();
  const char* after = body.data();
  for (const FormPart& part : *parts) {  // in order, not overlapping, inside the body
    if (part.body.data() < after || part.body.data() + part.body.size() > body.data() + body.size())
      std::abort();
    after = part.body.data() + part.body.size();
  }
  return 0;
}
