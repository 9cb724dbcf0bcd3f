// A table of settings. Each can be given as a flag --name, as the environment variable FRACTURE_NAME or as a
// key of a config file, in this order of precedence. All invalid values are reported together.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fracture::cli {

struct Setting {
  enum class Kind { kValue, kList, kFlag };  ///< a list is separated by commas; a flag is "true" or "false"

  std::string name;   ///< as in the flag, without the dashes
  std::string group;  ///< heading in --help
  std::string type;   ///< kind of value, for --help: "BYTES", "SECONDS"
  std::string doc;
  Kind kind = Kind::kValue;
  /// Sets the value. If it is invalid, returns the requirement ("must be …"), from which apply() makes an
  /// error with the name, the value and its source.
  std::function<std::optional<std::string>(const std::string&)> set;
  /// Returns the current value in the form that `set` reads.
  std::function<std::string()> get;
  bool secret = false;  ///< never printed

  std::string variable() const;  ///< FRACTURE_MAX_BODY for max-body
};

/// Whole numbers from low to high. The type "BYTES" also allows a suffix: 64KiB, 64MiB, 2GiB.
template <class Number>
Setting number(std::string name, std::string type, Number& target, std::uint64_t low, std::uint64_t high,
               std::string doc);
/// Seconds, with an optional fraction, from 0 to one day.
Setting seconds(std::string name, std::chrono::milliseconds& target, std::string doc);
Setting text(std::string name, std::string type, std::string& target, std::string doc);
Setting choice(std::string name, std::string& target, std::vector<std::string> choices, std::string doc);
Setting flag(std::string name, bool& target, std::string doc);
Setting list(std::string name, std::string type, std::vector<std::string>& target, std::string doc);

struct Given {
  std::string value;
  std::string where;  ///< "--max-body", "FRACTURE_MAX_BODY" or "line of <file>"
};
using GivenSettings = std::map<std::string, Given>;

/// Reads settings from `variables`, which is environ. Names of FRACTURE_ variables that are not settings are
/// added to `unknown`.
GivenSettings from_environment(const char* const* variables, std::span<const Setting> settings,
                               std::vector<std::string>& unknown);

/// Reads `name = value` lines (TOML without sections). Unreadable files and unknown or repeated keys are
/// added to `errors`.
GivenSettings from_file(const std::string& path, std::span<const Setting> settings,
                        std::vector<std::string>& errors);

/// Sets every setting that was given; `sources` are in descending precedence. Invalid values are added to
/// `errors`.
void apply(std::span<const Setting> settings, std::span<const GivenSettings> sources,
           std::vector<std::string>& errors);

/// Writes a config file. Given settings are written as they were given, so that from_file() reads the same
/// values on any machine. All other settings are comments with their current values.
std::string to_config_file(std::span<const Setting> settings, const GivenSettings& given);
/// Maps names to values; secrets are "***".
nlohmann::ordered_json to_json(std::span<const Setting> settings);

namespace detail {
/// Returns nothing if the text is not a number in the range.
std::optional<std::uint64_t> parse_number(const std::string& text, bool bytes, std::uint64_t low,
                                          std::uint64_t high);
/// Returns "must be a whole number from 1 to 9", or for bytes "must be from 1KiB to 1TiB, such as 64MiB".
std::string requirement(bool bytes, std::uint64_t low, std::uint64_t high);
/// Returns "64MiB", or "1,000 bytes" for a number that no unit divides.
std::string size_with_unit(std::uint64_t bytes);
}  // namespace detail

template <class Number>
Setting number(std::string name, std::string type, Number& target, std::uint64_t low, std::uint64_t high,
               std::string doc) {
  const bool bytes = type.starts_with("BYTES");
  Setting setting;
  setting.name = std::move(name);
  setting.type = std::move(type);
  setting.doc = std::move(doc);
  setting.set = [&target, bytes, low, high](const std::string& given) -> std::optional<std::string> {
    const std::optional<std::uint64_t> value = detail::parse_number(given, bytes, low, high);
    if (!value) return detail::requirement(bytes, low, high);
    target = static_cast<Number>(*value);
    return std::nullopt;
  };
  setting.get = [&target] { return std::to_string(target); };
  return setting;
}

}  // namespace fracture::cli
