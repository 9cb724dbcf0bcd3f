#include "server/service/kept_result.hpp"

#include <charconv>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/parameters/parameter_object.hpp"

namespace fracture {
namespace {

constexpr std::size_t kDigest = sizeof(Digest::bytes);

std::string_view text_of(const Digest& digest) {
  return {reinterpret_cast<const char*>(digest.bytes.data()), digest.bytes.size()};
}

/// Removes the first line from the text and returns it; nothing if there is no complete line.
std::optional<std::string_view> take_line(std::string_view& text) {
  const std::size_t end = text.find('\n');
  if (end == std::string_view::npos) return std::nullopt;
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(end + 1);
  return line;
}

/// Removes a range from the beginning of the line and returns it. Returns nothing if there is no range, or if it is not an
/// object in the file.
std::optional<TextRange> take_range(std::string_view& line, const std::vector<std::uint8_t>& file) {
  TextRange range;
  for (std::uint64_t* const number : {&range.at, &range.size}) {
    const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), *number);
    if (error != std::errc{}) return std::nullopt;
    line.remove_prefix(static_cast<std::size_t>(end - line.data()));
    if (!line.empty() && line.front() == ' ') line.remove_prefix(1);
  }
  if (range.at > file.size() || range.size > file.size() - range.at) return std::nullopt;
  if (range.size > 0 && (file[range.at] != '{' || file[range.at + range.size - 1] != '}'))
    return std::nullopt;
  return range;
}

/// Computes the digests of file and figures, and returns whether the entry ends with the same digests. Stored digests are
/// not trusted, because clients get them (Repr-Digest) and use them to verify the file.
bool has_digests(std::string_view rest, FractureResult& result, const Execution& execution) {
  result.file_digest = sha256(std::as_bytes(std::span(result.file)), execution);
  result.figures_digest = sha256(std::as_bytes(result.bytes_of(result.figures)), execution);
  return rest.size() == 2 * kDigest && rest.substr(0, kDigest) == text_of(result.file_digest) &&
         rest.substr(kDigest) == text_of(result.figures_digest);
}

bool is_digest(std::string_view text) {
  constexpr std::string_view kScheme = "sha256:", kDigits = "0123456789abcdef";
  return text.starts_with(kScheme) && text.size() == kScheme.size() + 2 * kDigest &&
         text.find_first_not_of(kDigits, kScheme.size()) == std::string_view::npos;
}

}  // namespace

std::string metadata_of(const FractureResult& result) {
  std::string text = result.format == OutputFormat::kGltf ? "gltf" : "glb";
  text += "\n" + result.mesh_digest + "\n";
  text += std::to_string(result.figures.at) + " " + std::to_string(result.figures.size) + "\n";
  text += result.parameters + "\n";
  return text.append(text_of(result.file_digest)).append(text_of(result.figures_digest));
}

std::shared_ptr<const FractureResult> result_in(const StoredEntry& stored, const Execution& execution) {
  std::string_view rest = stored.entry.metadata;
  const auto format = take_line(rest), mesh = take_line(rest);
  auto ranges = take_line(rest);
  if (!format || !mesh || !ranges || (*format != "gltf" && *format != "glb") || !is_digest(*mesh))
    return nullptr;
  auto result = std::make_shared<FractureResult>();
  result->key = stored.entry.key;
  result->format = *format == "gltf" ? OutputFormat::kGltf : OutputFormat::kGlb;
  result->mesh_digest = *mesh;
  // A result key begins with the digest of its mesh.
  if (mesh->substr(mesh->find(':') + 1, 16) != std::string_view(result->key).substr(0, 16)) return nullptr;
  result->file.reserve(stored.entry.payload.size());
  append_with_polls<std::uint8_t>(execution, result->file, stored.entry.payload);
  const auto figures = take_range(*ranges, result->file);
  if (!figures || figures->size == 0) return nullptr;  // every answer has figures
  result->figures = *figures;
  if (ranges->empty()) {
    const auto parameters = take_line(rest);
    if (!parameters) return nullptr;
    result->parameters = *parameters;
  } else {  // the format of earlier versions: the range of the parameters in the file
    const auto range = take_range(*ranges, result->file);
    if (!range || !ranges->empty() || range->size > kOfKept.text) return nullptr;
    const std::span<const std::uint8_t> text = result->bytes_of(*range);
    result->parameters.assign(text.begin(), text.end());
  }
  if (!has_digests(rest, *result, execution) || !read_kept_parameters(result->parameters)) return nullptr;
  return result;
}

}  // namespace fracture
