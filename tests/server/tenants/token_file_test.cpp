// The token file: what it may contain, and that every mistake is reported with its place and without a token.
#include "server/tenants/token_file.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "common/digest/digest.hpp"

namespace fracture::tenants {
namespace {

using nlohmann::json;
using testing::HasSubstr;

const std::string kDigest = sha256(std::string_view("0123456789abcdef")).hex();

json tenant(const std::string& name = "studio", const std::string& token = "0123456789abcdef") {
  return {{"name", name},
          {"tokens", {{{"sha256", sha256(std::string_view(token)).hex()}}}},
          {"scopes", {"read", "fracture"}}};
}
std::string file(const json& members) { return json{{"tenants", {members}}}.dump(); }

TEST(TokenFile, SaysNamesTokensScopesExpiryAndShares) {
  const auto read = TokenFile::parse(R"({"tenants": [{"name": "studio.a",
    "tokens": [{"sha256": ")" + kDigest +
                                     R"(", "expires": "2027-01-31T23:59:58Z"}],
    "scopes": ["read", "bake"], "requests_per_second": 2.5, "cores": 0.5, "computations": 8, "stored_bytes": 0,
    "cached_bytes": 1048576, "priority": "batch", "weight": 3}]})");
  ASSERT_TRUE(read) << read.error().detail;
  EXPECT_TRUE(read->isolated());
  const TokenFile::Match match = read->find("0123456789abcdef");
  ASSERT_TRUE(match.tenant);
  EXPECT_EQ(match.tenant->name, "studio.a");
  using namespace std::chrono;
  EXPECT_EQ(match.token->expires, sys_days(2027y / January / 31) + 23h + 59min + 58s);
  EXPECT_TRUE(match.tenant->scopes.has(Scope::kRead) && match.tenant->scopes.has(Scope::kBake));
  EXPECT_FALSE(match.tenant->scopes.has(Scope::kFracture) || match.tenant->scopes.has(Scope::kAdmin));
  const Shares& shares = match.tenant->shares;
  EXPECT_EQ(shares.requests_per_second, 2.5);
  EXPECT_EQ(shares.cores, 0.5);
  EXPECT_EQ(shares.computations, 8u);
  EXPECT_EQ(shares.stored_bytes, 0u);
  EXPECT_EQ(shares.cached_bytes, 1048576u);
  EXPECT_FALSE(shares.realtime);
  EXPECT_EQ(shares.weight, 3);
  EXPECT_FALSE(read->find("0123456789abcdeF").tenant);
  EXPECT_FALSE(read->find(kDigest).tenant) << "the digest is no token";
  EXPECT_FALSE(read->find("").tenant);
}

TEST(TokenFile, WhatIsLeftOutHasNoLimit) {
  const auto read = TokenFile::parse(file(tenant()));
  ASSERT_TRUE(read) << read.error().detail;
  const Shares& shares = read->tenants().front().shares;
  EXPECT_FALSE(shares.requests_per_second || shares.cores);
  EXPECT_EQ(shares.computations, Shares::kNoLimit);
  EXPECT_EQ(shares.stored_bytes, Shares::kNoLimit);
  EXPECT_TRUE(shares.realtime);
  EXPECT_EQ(shares.weight, 1);
}

TEST(TokenFile, EveryMistakeIsRefusedWithItsPlace) {
  const auto with = [](const char* member, json value) {
    json changed = tenant();
    changed[member] = std::move(value);
    return file(changed);
  };
  json nameless = tenant();
  nameless.erase("name");
  const std::string twice = R"({"tenants": [{"name": "a", "name": "b"}]})";
  const std::string deep = "{\"tenants\":" + std::string(100'000, '[') + std::string(100'000, ']') + "}";
  const std::pair<std::string, const char*> wrong[] = {
      {"{", "not one JSON object"},
      {"{} {}", "not one JSON object"},
      {deep, "not one JSON object"},
      {"{}", "tenants must be an array"},
      {R"({"tenants": []})", "tenants must be an array"},
      {R"({"tenants": [], "tenant": []})", "'tenant', which is not allowed"},
      {R"({"tenants": [7]})", "tenants[0] must be an object"},
      {twice, "'name' twice"},
      {file(nameless), "tenants[0].name"},
      {with("name", ""), "tenants[0].name"},
      {with("name", "a b"), "tenants[0].name"},
      {with("name", std::string(65, 'a')), "tenants[0].name"},
      {with("token", "0123456789abcdef"), "'token', which is not allowed"},
      {with("tokens", json::array()), "tenants[0].tokens must be"},
      {with("tokens", {"0123456789abcdef"}), "tenants[0].tokens[0] must be an object"},
      {with("tokens", {{{"sha256", "0123456789abcdef"}}}), "tokens[0].sha256"},
      {with("tokens", {{{"sha256", std::string(64, 'A')}}}), "tokens[0].sha256"},
      {with("tokens", {{{"sha256", kDigest}, {"expires", "tomorrow"}}}), "tokens[0].expires"},
      {with("tokens", {{{"sha256", kDigest}, {"expires", "2027-02-29T00:00:00Z"}}}), "tokens[0].expires"},
      {with("tokens", {{{"sha256", kDigest}, {"expires", "2027-01-01T00:00:00+01:00"}}}),
       "tokens[0].expires"},
      {with("tokens", {{{"sha256", kDigest}}, {{"sha256", kDigest}}}), "is in the file twice"},
      {with("scopes", json::array()), "tenants[0].scopes"},
      {with("scopes", {"read", "write"}), "tenants[0].scopes may contain only read"},
      {with("scopes", {"read", "read"}), "each once"},
      {with("scopes", "read"), "tenants[0].scopes"},
      {with("requests_per_second", 0), "requests_per_second must be a number from 0.001"},
      {with("requests_per_second", "many"), "requests_per_second must be"},
      {with("cores", -1), "cores must be"},
      {with("weight", 1e9), "weight must be"},
      {with("computations", 0), "computations must be a whole number of at least 1"},
      {with("computations", 1.5), "computations must be"},
      {with("stored_bytes", -1), "stored_bytes must be"},
      {with("cached_bytes", "1MiB"), "cached_bytes must be"},
      {with("priority", "high"), "priority must be \"realtime\" or \"batch\""},
      {json{{"tenants", {tenant("a"), tenant("a", "another-token-16")}}}.dump(), "tenants[1].name is 'a'"},
      {json{{"tenants", {tenant("a"), tenant("b")}}}.dump(), "tenants[1].tokens"},
  };
  for (const auto& [text, message] : wrong) {
    const auto read = TokenFile::parse(text);
    ASSERT_FALSE(read) << text.substr(0, 200);
    EXPECT_THAT(read.error().detail, HasSubstr(message)) << text.substr(0, 200);
    EXPECT_THAT(read.error().detail, testing::Not(HasSubstr("0123456789abcdef")))
        << "a token in an error message";
  }
}

TEST(TokenFile, LinesNameWhoShareEverything) {
  const auto read = TokenFile::parse("ana 0123456789abcdef\nbob 0123456789abcdeg read-only\n");
  ASSERT_TRUE(read);
  EXPECT_FALSE(read->isolated());
  const Scopes all = read->find("0123456789abcdef").tenant->scopes;
  EXPECT_TRUE(all.has(Scope::kRead) && all.has(Scope::kFracture) && all.has(Scope::kBake));
  EXPECT_FALSE(all.has(Scope::kAdmin));
  EXPECT_FALSE(read->find("0123456789abcdeg").tenant->scopes.has_any({Scope::kFracture, Scope::kBake}));
}

}  // namespace
}  // namespace fracture::tenants
