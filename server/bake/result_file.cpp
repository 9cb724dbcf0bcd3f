#include "server/bake/result_file.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "common/base/json_reader.hpp"
#include "common/outputs/answer.hpp"
#include "server/bake/report.hpp"
#include "server/service/figures.hpp"

namespace fracture::bake {
namespace {

using nlohmann::json;

/// Returns the JSON text of a glTF or a GLB (glTF 2.0, section 4.4: a 12-byte header, then the JSON chunk as
/// length, type and text). Empty if the file is neither.
std::string json_text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const std::streamoff size = file.tellg();
  char head[20];
  if (!file || size < static_cast<std::streamoff>(sizeof head)) return {};
  file.seekg(0);
  file.read(head, sizeof head);
  if (std::memcmp(head, "glTF", 4) != 0) {
    file.seekg(0);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  std::uint32_t length = 0;
  std::memcpy(&length, head + 12, 4);
  std::string text(std::min<std::size_t>(length, static_cast<std::size_t>(size) - sizeof head), '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  return file ? text : std::string();
}

bool has_our_extras(const json& node) {
  const auto extras = node.find("extras");
  if (extras == node.end() || !extras->is_object()) return false;
  const auto ours = extras->find("fracture");
  return ours != extras->end() && ours->is_object() && ours->contains("certificate");
}

/// Returns the first bytes that outputs.hpp writes in this format, or an empty string for other formats.
std::string first_words(MeshFormat format) {
  if (format == MeshFormat::kObj) return std::string("# ") + outputs::kGenerator;
  if (format == MeshFormat::kPly)
    return std::string("ply\nformat binary_little_endian 1.0\ncomment ") + outputs::kGenerator;
  return format == MeshFormat::kStl ? outputs::kGenerator : "";
}

}  // namespace

bool is_result_file(const std::string& path, MeshFormat format) {
  if (const std::string words = first_words(format); !words.empty()) {
    std::string begin(words.size(), '\0');
    std::ifstream file(path, std::ios::binary);
    return file.read(begin.data(), static_cast<std::streamsize>(begin.size())) && begin == words;
  }
  if (format != MeshFormat::kGlb && format != MeshFormat::kGltf) return false;
  const std::string text = json_text_of(path);
  if (text.find("fracture") == std::string::npos) return false;  // searching is faster than parsing
  // Meshes in a folder are untrusted files, so the JSON limits apply.
  const auto read = read_json(text, kOfAnAnswer);
  if (!read || !read->value.is_object()) return false;
  const json& document = read->value;
  if (const auto asset = document.find("asset"); asset != document.end() && asset->is_object())
    if (const auto by = asset->find("generator");
        by != asset->end() && by->is_string() &&
        by->get_ref<const std::string&>().starts_with("fracture, algorithm "))
      return true;
  const auto nodes = document.find("nodes");
  return nodes != document.end() && nodes->is_array() &&
         std::any_of(nodes->begin(), nodes->end(),
                     [](const json& node) { return node.is_object() && has_our_extras(node); });
}

void add_results_of_report(const std::string& report, std::set<FileIdentity>& results) {
  std::ifstream file(report);
  for (std::string line; std::getline(file, line);) {
    const json entry = json_or_null(line, kOfALine);
    if (!entry.is_object()) continue;
    const auto output = entry.find("output"), status = entry.find("status");
    if (output != entry.end() && output->is_string() && status != entry.end() && *status == "made")
      results.insert(identity_of(output->get<std::string>()));
  }
}

}  // namespace fracture::bake
