#include "common/import/sibling_files.hpp"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "common/import/gltf_entries.hpp"
#include "common/import/obj_lines.hpp"
#include "common/import/obj_names.hpp"
#include "common/import/text_encoding.hpp"
#include "common/import/text_words.hpp"
#include "common/import/uri.hpp"

namespace fracture {
namespace {

namespace fs = std::filesystem;

class Names {
 public:
  void add(std::string name) {
    std::replace(name.begin(), name.end(), '\\', '/');
    while (!name.empty() && (name.back() == ' ' || name.back() == '\r' || name.back() == '\t'))
      name.pop_back();
    name.erase(0, std::min(name.size(), name.find_first_not_of(" \t")));
    if (name.substr(0, 2) == "./") name.erase(0, 2);
    if (name.empty() || is_data_uri(name) || name.find("://") != std::string::npos) return;
    if (known_.insert(name).second) list_.push_back(std::move(name));
  }
  std::vector<std::string> take() { return std::move(list_); }

 private:
  std::vector<std::string> list_;
  std::set<std::string> known_;
};

void add_gltf(std::string_view bytes, Names& names) {
  std::vector<std::string> buffers, images;
  const bool read = read_gltf_entries(bytes, "uri", [&](const std::string& list, std::string& uri) {
    if ((list == "buffers" || list == "images") && !is_data_uri(uri))
      (list == "buffers" ? buffers : images).push_back(decode_percent(uri));
    return true;
  });
  if (!read) return;
  for (std::vector<std::string>* list : {&buffers, &images})
    for (std::string& name : *list) names.add(std::move(name));
}

/// Calls f(keyword, rest) for every line of an OBJ or MTL file that has both.
template <class F>
void for_lines(std::string_view text, F&& f) {
  ObjLines lines(text);
  for (std::string_view line; lines.next(line);) {
    const std::string_view keyword = take_word(line);
    if (!line.empty()) f(keyword, line);
  }
}

/// Comments in the header, as MeshLab writes them: "comment TextureFile wood grain.png".
void add_ply(std::string_view text, Names& names) {
  constexpr std::size_t kMaxHeader = 1u << 20;
  constexpr std::string_view kKey = "TextureFile ";
  const std::string_view header = text.substr(0, kMaxHeader);
  for_lines(header.substr(0, header.find("end_header")), [&](std::string_view key, std::string_view rest) {
    rest.remove_prefix(std::min(rest.size(), rest.find_first_not_of(" \t")));
    if (key == "comment" && rest.starts_with(kKey)) names.add(std::string(rest.substr(kKey.size())));
  });
}

void add_dae(std::string_view text, Names& names) {
  constexpr std::string_view kOpen = "<init_from>";
  for (std::size_t at = 0; (at = text.find(kOpen, at)) != std::string_view::npos;) {
    at += kOpen.size();
    const std::string_view value = text.substr(at, text.find('<', at) - at);
    names.add(decode_percent(value.substr(0, 7) == "file://" ? value.substr(7) : value));
  }
}

/// FBX properties. Binary: 'S', a 32-bit length and the text (after the record's name). ASCII: in quotes.
void add_fbx(std::string_view text, Names& names) {
  constexpr std::string_view kKey = "RelativeFilename";
  for (std::size_t at = 0; (at = text.find(kKey, at)) != std::string_view::npos;) {
    at += kKey.size();
    const std::string_view rest = text.substr(at);
    if (rest.size() > 5 && rest[0] == 'S') {
      std::uint32_t length = 0;
      std::memcpy(&length, rest.data() + 1, 4);
      if (length <= 4096 && length <= rest.size() - 5) names.add(std::string(rest.substr(5, length)));
    } else if (const std::size_t quote = rest.substr(0, 16).find('"'); quote != std::string_view::npos) {
      const std::size_t end = rest.find('"', quote + 1);
      if (end != std::string_view::npos && end - quote <= 4096)
        names.add(std::string(rest.substr(quote + 1, end - quote - 1)));
    }
  }
}

std::string read_whole(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Returns the regular file `name` in the folder; none if it does not exist or is outside the folder.
std::optional<fs::path> inside(const fs::path& folder, const std::string& name) {
  std::error_code error;
  const fs::path root = fs::canonical(folder, error);
  if (error) return std::nullopt;
  const fs::path file = fs::canonical(root / name, error);
  if (error || !fs::is_regular_file(file, error)) return std::nullopt;
  const auto [end, other] = std::mismatch(root.begin(), root.end(), file.begin(), file.end());
  return end == root.end() ? std::optional(file) : std::nullopt;
}

void read_named(const fs::path& folder, const std::vector<std::string>& names,
                std::vector<SiblingFile>& out) {
  for (const std::string& name : names) {
    const fs::path path(name);
    const bool plain = path.is_relative() && name.find(':') == std::string::npos &&
                       std::find(path.begin(), path.end(), "..") == path.end();
    std::string as = name;
    std::optional<fs::path> file = plain ? inside(folder, name) : std::nullopt;
    if (!file) {
      as = name.substr(name.rfind('/') + 1);
      if (as.empty() || as == "..") continue;
      file = inside(folder, as);
    }
    const bool known = std::any_of(out.begin(), out.end(), [&](const auto& f) { return f.name == as; });
    if (file && !known) out.push_back({as, read_whole(*file), (folder / as).string()});
  }
}

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return result;
}

/// Returns the files in the folder and its subfolders, sorted, without links.
std::vector<fs::path> files_below(const fs::path& folder) {
  constexpr int kMaxDepth = 2, kMaxEntries = 1000;
  std::vector<fs::path> files;
  std::error_code error;
  int entries = 0;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end && entries < kMaxEntries;
       it.increment(error), ++entries) {
    if (it.depth() >= kMaxDepth) it.disable_recursion_pending();
    if (it->is_regular_file(error) && !it->is_symlink(error)) files.push_back(it->path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// Whether a reader looks for this file next to an asset with this stem, even if the asset does not mention
/// it.
bool is_companion(const std::string& stem, const std::string& name) {
  std::string base = stem;
  if (base.ends_with("_a") || base.ends_with("_d")) base.resize(base.size() - 2);
  if (base.ends_with(".mesh")) base.resize(base.size() - 5);
  if (name.substr(0, base.size()) != base) return false;
  const std::string ending = name.substr(base.size());
  for (const char* known :
       {"_a.3d", "_d.3d", ".skin", "_default.skin", ".md5anim", ".material", ".skeleton.xml", "t.mdl"})
    if (ending == known) return true;
  const auto digit = [&](std::size_t k) { return ending[k] >= '0' && ending[k] <= '9'; };
  return ending.size() == 6 && digit(0) && digit(1) && ending.ends_with(".mdl");  // sequences of Half-Life
}

void read_mentioned(const fs::path& asset, const fs::path& folder, std::string_view bytes,
                    std::vector<SiblingFile>& out) {
  const auto text_of = [](std::string_view raw) {
    const auto converted = utf16_to_utf8(std::as_bytes(std::span(raw)));
    return lower(converted ? *converted : raw);
  };
  std::string text = text_of(bytes);
  const std::string stem = lower(asset.stem().string());
  std::vector<fs::path> candidates = files_below(folder);
  std::erase_if(candidates, [&](const fs::path& f) { return f.filename() == asset.filename(); });
  for (std::size_t next = 0;;) {
    std::erase_if(candidates, [&](const fs::path& file) {
      const std::string name = lower(file.filename().string());
      const bool mentioned = name.size() >= 5 && text.find(name) != std::string::npos;
      if (!mentioned && !(next == 0 && is_companion(stem, name))) return false;
      out.push_back({fs::relative(file, folder).generic_string(), read_whole(file), file.string()});
      return true;
    });
    if (next >= out.size()) return;
    text = text_of(out[next++].bytes);  // an object mentioned in the scene may mention its own textures
  }
}

}  // namespace

std::vector<std::string> referenced_files(std::span<const std::byte> bytes, MeshFormat format) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  Names names;
  switch (format) {
    case MeshFormat::kGlb:
    case MeshFormat::kGltf:
      add_gltf(text, names);
      break;
    case MeshFormat::kObj:
      for_lines(text, [&](std::string_view key, std::string_view rest) {
        if (key != "mtllib") return;
        for (std::string& name : material_libraries(rest)) names.add(std::move(name));
      });
      break;
    case MeshFormat::kPly:
      add_ply(text, names);
      break;
    case MeshFormat::kFbx:
      add_fbx(text, names);
      break;
    case MeshFormat::kDae:
      add_dae(text, names);
      break;
    default:
      break;
  }
  return names.take();
}

std::vector<std::string> textures_of_mtl(std::string_view text) {
  Names names;
  for_lines(text, [&](std::string_view key, std::string_view rest) {
    if (is_map(key)) names.add(std::string(file_of_map(rest).name));
  });
  return names.take();
}

std::vector<SiblingFile> read_sibling_files(const std::string& path, std::span<const std::byte> bytes,
                                            MeshFormat format) {
  fs::path folder = fs::path(path).parent_path();
  if (folder.empty()) folder = ".";
  std::vector<SiblingFile> files;
  switch (format) {
    case MeshFormat::kGlb:
    case MeshFormat::kGltf:
    case MeshFormat::kObj:
    case MeshFormat::kPly:
    case MeshFormat::kFbx:
    case MeshFormat::kDae:
      break;
    case MeshFormat::kStl:
    case MeshFormat::kOff:  // they refer to no other file
      return files;
    default:
      read_mentioned(path, folder, {reinterpret_cast<const char*>(bytes.data()), bytes.size()}, files);
      return files;
  }
  read_named(folder, referenced_files(bytes, format), files);
  if (format == MeshFormat::kObj)
    for (std::size_t k = 0, libraries = files.size(); k < libraries; ++k)
      read_named(folder, textures_of_mtl(std::string(files[k].bytes)), files);
  return files;
}

std::vector<ImportFile> as_import_files(const std::vector<SiblingFile>& files) {
  std::vector<ImportFile> views;
  for (const SiblingFile& file : files)
    views.push_back({file.name, std::as_bytes(std::span(file.bytes.data(), file.bytes.size()))});
  return views;
}

}  // namespace fracture
