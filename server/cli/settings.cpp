#include "server/cli/settings.hpp"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <system_error>
#include <utility>

#include "common/base/nearest_name.hpp"
#include "common/base/text.hpp"
#include "common/base/words.hpp"

namespace fracture::cli {
namespace {

constexpr std::string_view kPrefix = "FRACTURE_";
/// Prefix of variables that the tests read and the server ignores.
constexpr std::string_view kTestPrefix = "FRACTURE_TEST_";

const Setting* find(std::span<const Setting> settings, std::string_view name) {
  const auto at =
      std::find_if(settings.begin(), settings.end(), [&](const Setting& s) { return s.name == name; });
  return at == settings.end() ? nullptr : &*at;
}

std::string join(const std::vector<std::string>& items) {
  std::string joined;
  for (const std::string& item : items) joined += (joined.empty() ? "" : ",") + item;
  return joined;
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> items;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t comma = std::min(text.find(',', at), text.size());
    const std::string_view item = trimmed(std::string_view(text).substr(at, comma - at));
    if (!item.empty()) items.emplace_back(item);
    at = comma + 1;
  }
  return items;
}

/// Returns "debug, info or warn".
std::string either(const std::vector<std::string>& choices) {
  std::string text;
  for (std::size_t k = 0; k < choices.size(); ++k)
    text += (k == 0 ? "" : k + 1 < choices.size() ? ", " : " or ") + choices[k];
  return text;
}

/// Returns " (nearest: warn)"; empty if no choice is similar.
std::string nearest_of(const std::string& given, const std::vector<std::string>& choices) {
  const std::optional<std::string> nearest = nearest_name(given, choices);
  return nearest ? " (nearest: " + *nearest + ")" : "";
}

Setting make(std::string name, std::string type, std::string doc,
             Setting::Kind kind = Setting::Kind::kValue) {
  Setting setting;
  setting.name = std::move(name);
  setting.type = std::move(type);
  setting.doc = std::move(doc);
  setting.kind = kind;
  return setting;
}

/// Returns "; did you mean max-body?"; empty if no setting is similar.
std::string nearest_setting(const std::string& name, std::span<const Setting> settings) {
  std::vector<std::string> names;
  for (const Setting& setting : settings) names.push_back(setting.name);
  const std::optional<std::string> nearest = nearest_name(name, names);
  return nearest ? "; did you mean " + *nearest + "?" : "";
}

/// Returns whether the value is a number in JSON and TOML syntax.
bool is_plain_number(const std::string& value) {
  return nlohmann::json::parse(value, nullptr, /*allow_exceptions=*/false).is_number();
}

}  // namespace

std::string Setting::variable() const {
  std::string variable(kPrefix);
  for (const char c : name) variable += c == '-' ? '_' : c >= 'a' && c <= 'z' ? static_cast<char>(c - 32) : c;
  return variable;
}

std::optional<std::uint64_t> detail::parse_number(const std::string& text, bool bytes, std::uint64_t low,
                                                  std::uint64_t high) {
  std::uint64_t number = 0;
  const char* const last = text.data() + text.size();
  auto [end, error] = std::from_chars(text.data(), last, number);
  const std::string_view suffix(end, static_cast<std::size_t>(last - end));
  int shift = 0;
  bool understood = error == std::errc() && suffix.empty();
  if (bytes && error == std::errc() && !suffix.empty()) {
    shift = suffix == "KiB" ? 10 : suffix == "MiB" ? 20 : suffix == "GiB" ? 30 : 0;
    understood = shift > 0;
  }
  if (understood && shift > 0) {
    if (number > (UINT64_MAX >> shift)) understood = false;
    number <<= shift;
  }
  return understood && number >= low && number <= high ? std::optional(number) : std::nullopt;
}

std::string detail::size_with_unit(std::uint64_t bytes) {
  constexpr const char* kUnits[] = {"KiB", "MiB", "GiB", "TiB", "PiB"};
  if (bytes == 0 || bytes % 1024 != 0) return counted(bytes, "byte", "bytes");
  std::size_t unit = 0;
  for (bytes /= 1024; bytes % 1024 == 0 && unit + 1 < std::size(kUnits); ++unit) bytes /= 1024;
  return grouped(bytes) + kUnits[unit];
}

std::string detail::requirement(bool bytes, std::uint64_t low, std::uint64_t high) {
  if (bytes) return "must be from " + size_with_unit(low) + " to " + size_with_unit(high) + ", such as 64MiB";
  return "must be a whole number from " + grouped(low) + " to " + grouped(high);
}

Setting seconds(std::string name, std::chrono::milliseconds& target, std::string doc) {
  Setting setting = make(std::move(name), "SECONDS", std::move(doc));
  setting.set = [&target](const std::string& given) -> std::optional<std::string> {
    double value = 0;
    const auto [end, error] = std::from_chars(given.data(), given.data() + given.size(), value);
    if (error != std::errc() || end != given.data() + given.size() || !(value >= 0) || value > 86400)
      return "must be a number of seconds from 0 to 86,400";
    target = std::chrono::milliseconds(std::llround(value * 1000));
    return std::nullopt;
  };
  setting.get = [&target] {
    char digits[32];
    const auto [end, error] =
        std::to_chars(digits, digits + sizeof digits, static_cast<double>(target.count()) / 1000);
    return std::string(digits, end);
  };
  return setting;
}

Setting text(std::string name, std::string type, std::string& target, std::string doc) {
  Setting setting = make(std::move(name), std::move(type), std::move(doc));
  setting.set = [&target](const std::string& given) -> std::optional<std::string> {
    target = given;
    return std::nullopt;
  };
  setting.get = [&target] { return target; };
  return setting;
}

Setting choice(std::string name, std::string& target, std::vector<std::string> choices, std::string doc) {
  Setting setting = make(std::move(name), "", std::move(doc));
  for (const std::string& c : choices) setting.type += (setting.type.empty() ? "" : "|") + c;
  setting.set = [&target,
                 choices = std::move(choices)](const std::string& given) -> std::optional<std::string> {
    if (std::find(choices.begin(), choices.end(), given) == choices.end())
      return "must be " + either(choices) + nearest_of(given, choices);
    target = given;
    return std::nullopt;
  };
  setting.get = [&target] { return target; };
  return setting;
}

Setting flag(std::string name, bool& target, std::string doc) {
  Setting setting = make(std::move(name), "", std::move(doc), Setting::Kind::kFlag);
  setting.set = [&target](const std::string& given) -> std::optional<std::string> {
    if (given != "true" && given != "false") return "must be true or false";
    target = given == "true";
    return std::nullopt;
  };
  setting.get = [&target] { return std::string(target ? "true" : "false"); };
  return setting;
}

Setting list(std::string name, std::string type, std::vector<std::string>& target, std::string doc) {
  Setting setting = make(std::move(name), std::move(type), std::move(doc), Setting::Kind::kList);
  setting.set = [&target](const std::string& given) -> std::optional<std::string> {
    target = split(given);
    return std::nullopt;
  };
  setting.get = [&target] { return join(target); };
  return setting;
}

GivenSettings from_environment(const char* const* variables, std::span<const Setting> settings,
                               std::vector<std::string>& unknown) {
  GivenSettings given;
  for (; variables && *variables; ++variables) {
    const std::string_view entry(*variables);
    if (!entry.starts_with(kPrefix) || entry.starts_with(kTestPrefix)) continue;
    const std::string name(entry.substr(0, entry.find('=')));
    const auto at = std::find_if(settings.begin(), settings.end(),
                                 [&](const Setting& s) { return s.variable() == name; });
    if (at == settings.end())
      unknown.push_back(name);
    else
      given[at->name] = {std::string(entry.substr(std::min(entry.size(), name.size() + 1))), name};
  }
  return given;
}

GivenSettings from_file(const std::string& path, std::span<const Setting> settings,
                        std::vector<std::string>& errors) {
  GivenSettings given;
  std::vector<CLI::ConfigItem> items;
  if (std::error_code error; std::filesystem::is_directory(path, error)) {  // would be read as an empty file
    errors.push_back("--config '" + path + "' cannot be read: " + std::strerror(EISDIR));
    return given;
  }
  try {
    items = CLI::ConfigTOML().from_file(path);
  } catch (const CLI::Error& e) {
    const int missing = ::access(path.c_str(), R_OK) == 0 ? 0 : errno;
    errors.push_back("--config '" + path + "' " +
                     (missing != 0 ? std::string("cannot be read: ") + std::strerror(missing)
                                   : "is wrong: " + std::string(e.what())));
    return given;
  }
  for (const CLI::ConfigItem& item : items) {
    if (item.name == "++" || item.name == "--") continue;  // start and end of a section
    const std::string where = path + ": " + item.fullname();
    const Setting* const setting = item.parents.empty() ? find(settings, item.name) : nullptr;
    if (!setting)
      errors.push_back(where + " is not a setting" + nearest_setting(item.name, settings) +
                       " (--print-config lists them)");
    else if (given.contains(item.name) ||  // the parser merges adjacent entries with the same name
             (setting->kind != Setting::Kind::kList && item.inputs.size() != 1))
      errors.push_back(where + " must be given once, with one value");
    else
      given[item.name] = {join(item.inputs), path};
  }
  return given;
}

void apply(std::span<const Setting> settings, std::span<const GivenSettings> sources,
           std::vector<std::string>& errors) {
  for (const Setting& setting : settings) {
    for (const GivenSettings& source : sources) {
      const auto at = source.find(setting.name);
      if (at == source.end()) continue;
      if (const std::optional<std::string> requirement = setting.set(at->second.value))
        errors.push_back(setting.name + " " + *requirement +
                         (setting.secret ? "" : "; it was '" + at->second.value + "'") + " (" +
                         at->second.where + ")");
      break;
    }
  }
}

std::string to_config_file(std::span<const Setting> settings, const GivenSettings& given) {
  std::string file, group;
  for (const Setting& setting : settings) {
    if (setting.group != group) file += "\n# " + (group = setting.group) + "\n";
    const auto at = given.find(setting.name);
    const bool is_given = at != given.end(), hidden = setting.secret && !setting.get().empty();
    const std::string value = hidden ? "***" : is_given ? at->second.value : setting.get();
    const bool bare = setting.kind == Setting::Kind::kFlag || is_plain_number(value);
    file += "# " + setting.doc + "\n" + (is_given && !hidden ? "" : "# ") + setting.name + " = " +
            (bare ? value : "\"" + value + "\"") + "\n";
  }
  return file;
}

nlohmann::ordered_json to_json(std::span<const Setting> settings) {
  nlohmann::ordered_json object = nlohmann::ordered_json::object();
  for (const Setting& setting : settings) {
    const std::string value = setting.get();
    if (setting.secret && !value.empty())
      object[setting.name] = "***";
    else if (setting.kind == Setting::Kind::kFlag)
      object[setting.name] = value == "true";
    else if (is_plain_number(value))
      object[setting.name] = nlohmann::ordered_json::parse(value, nullptr, false);
    else
      object[setting.name] = value;
  }
  return object;
}

}  // namespace fracture::cli
