#include "server/bake/input_file.hpp"

#include <unistd.h>

#include <fstream>
#include <iterator>
#include <utility>

namespace fracture::bake {

Expected<MeshFormat> format_of_input(const std::string& path, const RequestParameters& parameters) {
  if (parameters.format) return *parameters.format;
  if (const auto format = format_from_extension(path.substr(path.rfind('.') + 1))) return *format;
  return fail(ErrorCode::kUnknownFormat, "The name '" + path + "' has no known ending; say --format.");
}

bool is_readable(const std::string& path) { return ::access(path.c_str(), R_OK) == 0; }

std::optional<InputFile> read_input(const std::string& path, MeshFormat format) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  InputFile input;
  input.bytes.assign(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  if (file.bad()) return std::nullopt;
  input.siblings = read_sibling_files(path, input.view(), format);
  return input;
}

}  // namespace fracture::bake
