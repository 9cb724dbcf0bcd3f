#include "client/app/output_places.hpp"

#include <ctime>
#include <filesystem>
#include <vector>

#include "common/base/printable.hpp"

namespace fracture::app {
namespace {

namespace fs = std::filesystem;

struct Place {
  std::string flag;
  const std::string& path;
  bool written;
};

/// Whether two paths name the same file. The files need not exist.
bool are_one(const std::string& a, const std::string& b) {
  std::error_code error;
  if (fs::is_character_file(a, error)) return false;  // devices such as /dev/null keep nothing
  if (fs::equivalent(a, b, error) && !error) return true;
  const auto place = [&](const std::string& path) {
    // weakly_canonical leaves a relative path relative if none of it exists.
    fs::path whole = fs::weakly_canonical(fs::absolute(path, error), error);
    return whole.has_filename() ? whole : whole.parent_path();  // "folder/" is "folder"
  };
  const fs::path left = place(a);
  if (error) return a == b;
  const fs::path right = place(b);
  return error ? a == b : left == right;
}

}  // namespace

std::optional<std::string> same_place(const Options& options) {
  std::vector<Place> places{{"--record", options.record, true},
                            {"--wav", options.wav, true},
                            {"--log", options.log, true},
                            {"--replay", options.replay, false},
                            {"--continue", options.continue_from, false}};
  for (const std::string& file : options.files) places.push_back({"the mesh", file, false});
  for (std::size_t k = 0; k < places.size(); ++k)
    for (std::size_t other = 0; other < k; ++other) {
      const Place &a = places[other], &b = places[k];
      if (a.path.empty() || b.path.empty() || !(a.written || b.written) || !are_one(a.path, b.path)) continue;
      return a.flag + " and " + b.flag + " are both '" + printable(b.path) + "'. Specify different files.";
    }
  return std::nullopt;
}

std::string unused_name(const std::string& folder, const std::string& stem, const std::string& ending) {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  char when[32];
  std::strftime(when, sizeof when, "-%Y%m%d-%H%M%S", &local);
  std::error_code ignored;
  fs::path path;
  int number = 1;
  do {
    path = fs::path(folder) / (stem + when + (number == 1 ? "" : "-" + std::to_string(number)) + ending);
    ++number;
  } while (fs::exists(path, ignored));
  return path.string();
}

}  // namespace fracture::app
