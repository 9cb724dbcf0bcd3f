#include "server/service/failure_keeper.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <ctime>
#include <exception>
#include <fstream>
#include <set>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "common/base/atomic_file.hpp"
#include "common/base/json_text.hpp"
#include "common/parameters/as_text.hpp"
#include "common/pipeline/algorithm_version.hpp"
#include "common/pipeline/fracture.hpp"
#include "server/cache/folder_lock.hpp"

namespace fracture {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Digits of the result's key in a folder name: the 16 of the mesh, and 16 of the request.
constexpr std::size_t kDigits = 32;
/// Disk space that even a small file takes.
constexpr std::uint64_t kLeastBytes = 4096;
/// Maximum total length of the flags in a command. Linux rejects a single argument of 128 KiB.
constexpr std::size_t kMaxCommand = 100'000;
/// After this time, an unfinished folder must have been left by a process that was killed.
constexpr std::chrono::minutes kAbandoned{10};

bool is_failure_name(const std::string& name) {
  return name.size() == kDigits && std::all_of(name.begin(), name.end(), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

std::uint64_t bytes_below(const fs::path& folder) {
  std::uint64_t bytes = 0;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) bytes += std::max<std::uint64_t>(entry.file_size(), kLeastBytes);
  return bytes;
}

void write_whole(const fs::path& path, std::string_view bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) throw std::runtime_error("'" + path.string() + "' cannot be written");
}

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Assigns each file name a path inside one folder. Names come from untrusted clients, so no path may lead out of the folder
/// or collide with another one.
class Places {
 public:
  /// Returns the name itself if it is a plain relative path. Otherwise returns its last component, because importers look for
  /// that if a mesh names a path to another folder. If that fails too, returns "file-N".
  std::string place(std::string name) {
    std::replace(name.begin(), name.end(), '\\', '/');
    while (name.starts_with("./")) name.erase(0, 2);
    if (!take(name)) {
      name.erase(0, name.rfind('/') + 1);
      if (!take(name)) do
          name = "file-" + std::to_string(++unnamed_);
        while (!take(name));
    }
    return name;
  }

 private:
  bool take(const std::string& name) {
    if (name.empty() || name.size() > 1000 || name.front() == '/' || name.back() == '/') return false;
    std::vector<std::string> above;
    for (std::size_t at = 0; at < name.size();) {
      const std::size_t end = std::min(name.find('/', at), name.size());
      const std::string part = name.substr(at, end - at);
      const bool plain = std::all_of(part.begin(), part.end(), [](char c) {
        return static_cast<unsigned char>(c) >= 0x20 && c != 0x7f;
      });
      if (!plain || part.empty() || part == "." || part == ".." || part.size() > 200) return false;
      if (end < name.size()) above.push_back(name.substr(0, end));
      at = end + 1;
    }
    if (files_.contains(name) || folders_.contains(name) ||
        std::any_of(above.begin(), above.end(), [&](const std::string& f) { return files_.contains(f); }))
      return false;
    files_.insert(name);
    folders_.insert(above.begin(), above.end());
    return true;
  }

  std::set<std::string> files_, folders_;
  int unnamed_ = 0;
};

/// Quotes a word for a shell. Plain words stay as they are; all others get single quotes.
std::string quoted(const std::string& word) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_=.,/:+";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

std::string now() {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm utc{};
  ::gmtime_r(&seconds, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

/// Returns the `bake` flags for these parameters. Returns nothing if text cannot express them, or if they are too long for a
/// command line.
std::optional<std::vector<std::string>> flags_of(const json& canonical) {
  std::vector<std::string> flags;
  std::size_t length = 0;
  for (const auto& [name, value] : canonical.items()) {
    const std::optional<std::string> text = as_text(value);
    if (!text || text->find('\0') != std::string::npos) return std::nullopt;
    flags.push_back("--" + name + "=" + *text);
    if ((length += flags.back().size()) > kMaxCommand) return std::nullopt;
  }
  return flags;
}

}  // namespace

FailureKeeper::FailureKeeper(FailureKeeperConfig config, std::function<void(const std::string&)> say)
    : config_(std::move(config)), say_(std::move(say)) {}

Expected<void> FailureKeeper::make_folder() const {
  if (!any()) return {};
  std::error_code error;
  fs::create_directories(config_.folder, error);
  if (!error && ::access(config_.folder.c_str(), W_OK | X_OK) != 0)
    error = std::error_code(errno, std::generic_category());
  // The check above lets root pass everywhere, even in a folder in which the system allows no files.
  AtomicFile probe;
  if (!error && !probe.open((fs::path(config_.folder) / "request.json").string()))
    error = std::error_code(errno, std::generic_category());
  if (error) return tl::unexpected<Error>(unusable_folder(config_.folder, error.message()));
  return {};
}

KeptFailures FailureKeeper::figures() const {
  const std::lock_guard lock(mutex_);
  return figures_;
}

/// Counts the failures that are in the folder now, so removing an examined failure makes room.
bool FailureKeeper::has_room(std::uint64_t bytes) const {
  std::size_t failures = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(config_.folder))
    if (is_failure_name(entry.path().filename().string()) && entry.is_directory()) {
      ++failures;
      bytes += bytes_below(entry.path());
    }
  return failures < config_.max_failures && bytes <= config_.max_bytes;
}

void FailureKeeper::keep(const FractureRequest& request, const Error& error, const json& certificate,
                         std::string_view mesh_name) noexcept {
  if (!any()) return;
  std::string trouble;
  try {
    const std::lock_guard lock(mutex_);
    try {
      write(request, error, certificate, mesh_name);
      return;
    } catch (const std::exception& e) {
      if (++figures_.unwritten > 1 || !say_) return;
      trouble = e.what();
    }
  } catch (...) {  // locking failed
    return;
  }
  try {
    say_("Failures cannot be saved in '" + config_.folder + "': " + trouble);
  } catch (...) {  // only the message is lost
  }
}

void FailureKeeper::write(const FractureRequest& request, const Error& error, const json& certificate,
                          std::string_view mesh_name) {
  const RequestKeys keys = keys_of(request);
  const std::string name = keys.result.substr(0, kDigits), extension = extension_of(request.format);
  const fs::path folder = config_.folder, place = folder / name, temporary = folder / ("." + name + ".part");
  if (fs::exists(place)) {
    ++figures_.known;
    return;
  }

  std::uint64_t bytes = std::max<std::uint64_t>(request.mesh.size(), kLeastBytes) + 2 * kLeastBytes;
  Places places;
  const std::string mesh =
      "mesh/" + places.place(mesh_name.empty() ? "mesh." + extension : std::string(mesh_name));
  json files = json::array();
  for (const ImportFile& file : request.files) {
    files.push_back({{"name", file.name}, {"file", "mesh/" + places.place(file.name)}});
    bytes += std::max<std::uint64_t>(file.bytes.size(), kLeastBytes);
  }
  const json parameters = canonical_parameters(request.parameters);
  const char* const output = request.output == OutputFormat::kGltf ? "fragments.gltf" : "fragments.glb";
  const std::optional<std::vector<std::string>> flags = flags_of(parameters);
  std::string command = "fracture-server bake", manifest;
  if (flags) {
    for (const std::string& word : {mesh, std::string("-o"), std::string(output), "--format=" + extension})
      command += " " + quoted(word);
    for (const std::string& flag : *flags) command += " " + quoted(flag);
  } else {
    json all = parameters;
    all["format"] = extension;
    manifest = json_text(json{{"input", mesh}, {"output", output}, {"parameters", std::move(all)}}) + "\n";
    command += " --manifest job.ndjson --report again.ndjson";
  }
  const json document = {
      {"key", keys.result},
      {"time", now()},
      {"program", config_.program},
      {"algorithm", kAlgorithmVersion},
      {"error",
       {{"type", std::string("/problems/") + slug(error.code)},
        {"title", title(error.code)},
        {"detail", error.detail},
        {"parameter", error.pointer},
        {"figures", *error.extra}}},
      {"certificate",
       certificate.is_null() && error.code == ErrorCode::kUnsound ? *error.extra : certificate},
      {"mesh", {{"file", mesh}, {"format", extension}, {"digest", "sha256:" + keys.digest}}},
      {"files", std::move(files)},
      {"parameters", parameters},
      {"command", command}};
  const std::string text = json_text(document, 2) + "\n";
  bytes += text.size() + manifest.size();

  fs::create_directories(folder);
  if (!has_room(bytes)) {
    ++figures_.dropped;
    return;
  }
  if (!fs::create_directory(temporary)) {
    if (fs::file_time_type::clock::now() - fs::last_write_time(temporary) < kAbandoned) {
      ++figures_.known;  // another process is writing it
      return;
    }
    fs::remove_all(temporary);
    fs::create_directory(temporary);
  }
  try {
    const auto put = [&](const std::string& file, std::string_view content) {
      fs::create_directories((temporary / file).parent_path());
      write_whole(temporary / file, content);
    };
    put(mesh, text_of(request.mesh));
    for (std::size_t k = 0; k < request.files.size(); ++k)
      put(document.at("files").at(k).at("file").get<std::string>(), text_of(request.files[k].bytes));
    if (!manifest.empty()) put("job.ndjson", manifest);
    put("request.json", text);
    fs::rename(temporary, place);
  } catch (...) {
    std::error_code ignored;
    fs::remove_all(temporary, ignored);
    throw;
  }
  ++figures_.kept;
}

}  // namespace fracture
