// Parses the JSON form of the token file. It decides access rights, so parsing is strict: unknown or repeated members are
// errors and never ignored.
#include <algorithm>
#include <ctime>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "common/base/json_reader.hpp"
#include "server/tenants/token_file.hpp"

namespace fracture::tenants {
namespace {

using nlohmann::json;

/// An error and its place ("tenants[1].scopes"). Thrown only within this file.
struct Wrong {
  std::string place, what;
};

json parse_once(std::string_view text) {
  constexpr JsonLimits kLimits{.depth = 5, .bytes = 16u << 20};  // object, tenants, tenant, tokens, token
  auto read = read_json(text, kLimits);
  if (!read && read.error().kind == JsonFault::Kind::kRepeated)
    throw Wrong{"", "has the member '" + read.error().name + "' twice in one object"};
  if (!read || !read->value.is_object()) throw Wrong{"", "is not one JSON object {\"tenants\": [...]}"};
  return std::move(read->value);
}

void only(const json& object, const std::string& place, std::initializer_list<std::string_view> known) {
  if (!object.is_object()) throw Wrong{place, "must be an object"};
  for (const auto& [name, value] : object.items())
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw Wrong{place, "has a member '" + name.substr(0, 64) + "', which is not allowed here"};
}

const json& array(const json& object, const char* name, const std::string& place, std::size_t most) {
  const auto at = object.find(name);
  if (at == object.end() || !at->is_array() || at->empty() || at->size() > most)
    throw Wrong{place + name, "must be an array with 1 to " + std::to_string(most) + " members"};
  return *at;
}

std::optional<double> number(const json& object, const char* name, const std::string& place, double low,
                             double high) {
  const auto at = object.find(name);
  if (at == object.end()) return std::nullopt;
  if (!at->is_number() || !(at->get<double>() >= low && at->get<double>() <= high))
    throw Wrong{place + name, "must be a number from " + json(low).dump() + " to " + json(high).dump()};
  return at->get<double>();
}

std::uint64_t count(const json& object, const char* name, const std::string& place, std::uint64_t low) {
  const auto at = object.find(name);
  if (at == object.end()) return Shares::kNoLimit;
  if (!at->is_number_unsigned() || at->get<std::uint64_t>() < low)
    throw Wrong{place + name, "must be a whole number of at least " + std::to_string(low)};
  return at->get<std::uint64_t>();
}

std::string name_of(const json& tenant, const std::string& place) {
  const auto at = tenant.find("name");
  if (at != tenant.end() && at->is_string()) {
    const auto name = at->get<std::string>();
    const auto fits = [](char c) {
      return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '.' ||
             c == '_' || c == '-';
    };
    if (!name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), fits)) return name;
  }
  throw Wrong{place + "name", "must be 1 to 64 characters: letters, digits or any of ._-"};
}

Token token_of(const json& given, const std::string& place) {
  only(given, place, {"sha256", "expires"});
  const auto at = given.find("sha256");
  const auto value = [](char c) {
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
  };
  std::string digits;
  if (at != given.end() && at->is_string()) digits = at->get<std::string>();
  if (digits.size() != 64 || std::any_of(digits.begin(), digits.end(), [&](char c) { return value(c) < 0; }))
    throw Wrong{place + ".sha256", "must be the 64 lower-case hex digits of the token's SHA-256"};
  Token token;
  for (std::size_t k = 0; k < token.digest.size(); ++k)
    token.digest[k] = static_cast<std::uint8_t>(16 * value(digits[2 * k]) + value(digits[2 * k + 1]));
  if (const auto expires = given.find("expires"); expires != given.end()) {
    if (expires->is_string()) token.expires = parse_utc(expires->get<std::string>());
    if (!token.expires) throw Wrong{place + ".expires", "must be a time such as 2027-01-31T00:00:00Z"};
  }
  return token;
}

Scopes scopes_of(const json& tenant, const std::string& place) {
  constexpr std::pair<const char*, Scope> kKnown[] = {{"read", Scope::kRead},
                                                      {"fracture", Scope::kFracture},
                                                      {"bake", Scope::kBake},
                                                      {"admin", Scope::kAdmin}};
  Scopes scopes;
  for (const json& given : array(tenant, "scopes", place, std::size(kKnown))) {
    const auto known = std::find_if(std::begin(kKnown), std::end(kKnown),
                                    [&](const auto& entry) { return given == entry.first; });
    if (known == std::end(kKnown) || scopes.has(known->second))
      throw Wrong{place + "scopes", "may contain only read, fracture, bake and admin, each once"};
    scopes.add(known->second);
  }
  return scopes;
}

Shares shares_of(const json& tenant, const std::string& place) {
  Shares shares;
  shares.requests_per_second = number(tenant, "requests_per_second", place, 0.001, 1e6);
  shares.cores = number(tenant, "cores", place, 0.001, 1e4);
  shares.weight = number(tenant, "weight", place, 0.001, 1000).value_or(1);
  shares.computations = count(tenant, "computations", place, 1);
  shares.stored_bytes = count(tenant, "stored_bytes", place, 0);
  shares.cached_bytes = count(tenant, "cached_bytes", place, 0);
  if (const auto at = tenant.find("priority"); at != tenant.end()) {
    if (*at != "realtime" && *at != "batch")
      throw Wrong{place + "priority", "must be \"realtime\" or \"batch\""};
    shares.realtime = *at == "realtime";
  }
  return shares;
}

Tenant tenant_of(const json& given, const std::string& at) {
  only(given, at,
       {"name", "tokens", "scopes", "requests_per_second", "cores", "computations", "stored_bytes",
        "cached_bytes", "priority", "weight"});
  const std::string place = at + ".";
  Tenant tenant;
  tenant.name = name_of(given, place);
  std::size_t k = 0;
  for (const json& token : array(given, "tokens", place, TokenFile::kMaxTokens))
    tenant.tokens.push_back(token_of(token, place + "tokens[" + std::to_string(k++) + "]"));
  tenant.scopes = scopes_of(given, place);
  tenant.shares = shares_of(given, place);
  return tenant;
}

}  // namespace

std::optional<std::chrono::sys_seconds> parse_utc(std::string_view text) {
  constexpr std::string_view kForm = "dddd-dd-ddTdd:dd:ddZ";
  if (text.size() != kForm.size()) return std::nullopt;
  for (std::size_t k = 0; k < text.size(); ++k)
    if (kForm[k] == 'd' ? text[k] < '0' || text[k] > '9' : text[k] != kForm[k]) return std::nullopt;
  const auto digits = [&](std::size_t begin, std::size_t n) {
    int value = 0;
    for (std::size_t k = begin; k < begin + n; ++k) value = 10 * value + (text[k] - '0');
    return value;
  };
  using namespace std::chrono;
  const year_month_day day{year(digits(0, 4)), month(static_cast<unsigned>(digits(5, 2))),
                           std::chrono::day(static_cast<unsigned>(digits(8, 2)))};
  const int hour = digits(11, 2), minute = digits(14, 2), second = digits(17, 2);
  if (!day.ok() || hour > 23 || minute > 59 || second > 59) return std::nullopt;
  return sys_days(day) + hours(hour) + minutes(minute) + seconds(second);
}

Expected<TokenFile> TokenFile::parse_json(std::string_view text) try {
  const json document = parse_once(text);
  only(document, "", {"tenants"});
  TokenFile file;
  file.isolated_ = true;
  std::set<std::string> names;
  std::set<std::array<std::uint8_t, 32>> digests;
  std::size_t k = 0;
  for (const json& given : array(document, "tenants", "", kMaxTenants)) {
    const std::string place = "tenants[" + std::to_string(k++) + "]";
    Tenant tenant = tenant_of(given, place);
    if (!names.insert(tenant.name).second)
      throw Wrong{place + ".name",
                  "is '" + tenant.name +
                      "', which is also the name of an earlier member; each name may occur only once"};
    for (const Token& token : tenant.tokens)
      if (!digests.insert(token.digest).second)
        throw Wrong{place + ".tokens",
                    "has a token that is in the file twice; each token may occur only once"};
    file.tenants_.push_back(std::move(tenant));
  }
  return file;
} catch (const Wrong& wrong) {
  return fail(ErrorCode::kBadParameter, (wrong.place.empty() ? "" : ": " + wrong.place) + " " + wrong.what);
}

}  // namespace fracture::tenants
