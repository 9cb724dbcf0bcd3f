#include "server/page/samples.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "common/base/json_text.hpp"
#include "common/base/printable.hpp"

namespace fracture::page {
namespace {

namespace fs = std::filesystem;

std::string name_of(std::size_t number) { return "sample-" + std::to_string(number); }

}  // namespace

Expected<Samples> Samples::load(const std::vector<std::string>& paths) {
  if (paths.size() > kMostSamples)
    return fail(ErrorCode::kTooLarge, "There are " + std::to_string(paths.size()) +
                                          " page-samples; the limit is " + std::to_string(kMostSamples) +
                                          ".");
  Samples samples;
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  std::uint64_t all = 0;
  for (const std::string& path : paths) {
    std::error_code error;
    if (!fs::is_regular_file(path, error))
      return fail(ErrorCode::kFileAccess,
                  printable(path) + (error ? ": " + error.message() : " is not a file"));
    std::ifstream file(path, std::ios::binary);
    std::string bytes(kMostSampleBytes + 1 - all, '\0');
    file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    bytes.resize(static_cast<std::size_t>(file.gcount()));
    bytes.shrink_to_fit();
    all += bytes.size();
    if (all > kMostSampleBytes)
      return fail(ErrorCode::kTooLarge, "With " + printable(path) + ", the page's samples take more than " +
                                            std::to_string(kMostSampleBytes >> 20) +
                                            " MiB in total, which is the limit.");
    if (file.bad() || bytes.empty())
      return fail(ErrorCode::kFileAccess,
                  printable(path) + (file.is_open() && !file.bad() ? " is empty" : " cannot be read"));
    list.push_back({{"name", fs::path(path).filename().string()},
                    {"file", name_of(samples.files_.size())},
                    {"bytes", bytes.size()}});
    samples.files_.push_back(std::move(bytes));
  }
  samples.list_ = json_text(list) + "\n";
  return samples;
}

const std::string* Samples::find(std::string_view file) const {
  for (std::size_t k = 0; k < files_.size(); ++k)
    if (file == name_of(k)) return &files_[k];
  return nullptr;
}

}  // namespace fracture::page
