#include "common/import/uri.hpp"

#include <algorithm>

namespace fracture {
namespace {

int hex_value(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

int base64_value(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+' || c == '-') return 62;
  return c == '/' || c == '_' ? 63 : -1;
}

}  // namespace

bool is_data_uri(std::string_view uri) { return uri.substr(0, 5) == "data:"; }

std::optional<DataUri> decode_data_uri(std::string_view uri) {
  const std::size_t comma = uri.find(',');
  if (!is_data_uri(uri) || comma == std::string_view::npos) return std::nullopt;
  std::string_view head = uri.substr(5, comma - 5);
  constexpr std::string_view kBase64 = ";base64";
  if (head.size() < kBase64.size() || head.substr(head.size() - kBase64.size()) != kBase64)
    return std::nullopt;
  DataUri result;
  result.media_type = head.substr(0, std::min(head.find(';'), head.size()));
  std::string_view body = uri.substr(comma + 1);
  while (!body.empty() && body.back() == '=') body.remove_suffix(1);
  if (body.size() % 4 == 1) return std::nullopt;
  result.bytes.reserve(body.size() / 4 * 3 + 2);
  std::uint32_t bits = 0;
  int have = 0;
  for (const char c : body) {
    const int value = base64_value(c);
    if (value < 0) return std::nullopt;
    bits = bits << 6 | static_cast<std::uint32_t>(value);
    have += 6;
    if (have >= 8) {
      have -= 8;
      result.bytes.push_back(static_cast<std::uint8_t>(bits >> have & 0xff));
    }
  }
  return result;
}

std::string decode_percent(std::string_view uri) {
  std::string name;
  for (std::size_t k = 0; k < uri.size(); ++k) {
    const bool escaped =
        uri[k] == '%' && k + 2 < uri.size() && hex_value(uri[k + 1]) >= 0 && hex_value(uri[k + 2]) >= 0;
    if (escaped) {
      name += static_cast<char>(hex_value(uri[k + 1]) * 16 + hex_value(uri[k + 2]));
      k += 2;
    } else {
      name += uri[k];
    }
  }
  return name;
}

namespace {
char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }
}  // namespace

const ImportFile* find_file(std::span<const ImportFile> files, std::string_view uri) {
  std::string name = decode_percent(uri);
  if (name.substr(0, 2) == "./") name.erase(0, 2);
  const auto named = [&](const std::string& wanted) {
    const auto it =
        std::find_if(files.begin(), files.end(), [&](const ImportFile& file) { return file.name == wanted; });
    return it == files.end() ? nullptr : &*it;
  };
  if (const ImportFile* file = named(name)) return file;
  std::replace(name.begin(), name.end(), '\\', '/');
  if (const ImportFile* file = named(name)) return file;
  const std::string last = name.substr(name.rfind('/') + 1);
  if (const ImportFile* file = named(last)) return file;
  const ImportFile* alike = nullptr;
  for (const ImportFile& file : files) {
    const bool same = std::equal(file.name.begin(), file.name.end(), last.begin(), last.end(),
                                 [](char a, char b) { return lower(a) == lower(b); });
    if (!same) continue;
    if (alike != nullptr) return nullptr;  // the order of the parts must not decide
    alike = &file;
  }
  return alike;
}

}  // namespace fracture
