// A table of settings, each of which may be given as a flag --name, as the environment variable FRACTURE_NAME
// and as a key of a config file; the first of these that gives it decides. Nothing is half applied: every
// wrong value, wherever it was given, is found in one go.
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
  enum class Kind { kValue, kList, kFlag };  ///< a list is written with commas; a flag is "true" or "false"

  std::string name;   ///< as in the flag, without the dashes
  std::string group;  ///< heading in --help
  std::string type;   ///< what the value is, for --help: "BYTES", "SECONDS"
  std::string doc;
  Kind kind = Kind::kValue;
  /// Takes the value, or says what it would have to be: "must be …". No error yet: apply() makes one, with the name, the
  /// value and where it was given.
  std::function<std::optional<std::string>(const std::string&)> set;
  /// The present value in the form that `set` reads.
  std::function<std::string()> get;
  bool secret = false;  ///< never printed

  std::string variable() const;  ///< FRACTURE_MAX_BODY for max-body
};

/// Whole numbers from low to high. With type "BYTES" also with a suffix: 64KiB, 64MiB, 2GiB.
template <class Number>
Setting number(std::string name, std::string type, Number& target, std::uint64_t low, std::uint64_t high,
               std::string doc);
/// Seconds with a fraction, 0 to a day.
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

/// `variables` is environ. Names of FRACTURE_ variables that are no setting are added to `unknown`.
GivenSettings from_environment(const char* const* variables, std::span<const Setting> settings,
                               std::vector<std::string>& unknown);

/// Reads `name = value` lines (TOML without sections). Unreadable files, unknown and repeated keys become
/// errors.
GivenSettings from_file(const std::string& path, std::span<const Setting> settings,
                        std::vector<std::string>& errors);

/// Sets everything that was given; `sources` in falling precedence. Wrong values become errors.
void apply(std::span<const Setting> settings, std::span<const GivenSettings> sources,
           std::vector<std::string>& errors);

/// As a config file: what was given, as it was given, so that from_file reads the same back on any machine. All others are
/// comments that say what is in force here.
std::string to_config_file(std::span<const Setting> settings, const GivenSettings& given);
/// Name to value; secrets as "***".
nlohmann::ordered_json to_json(std::span<const Setting> settings);

namespace detail {
/// Nothing where it is none, or lies outside.
std::optional<std::uint64_t> parse_number(const std::string& text, bool bytes, std::uint64_t low,
                                          std::uint64_t high);
/// "must be a whole number from 1 to 9".
std::string requirement(bool bytes, std::uint64_t low, std::uint64_t high);
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
