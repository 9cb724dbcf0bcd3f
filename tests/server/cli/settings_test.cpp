// The settings of `serve`: their precedence, and that all mistakes are reported at once.
#include "server/cli/serve_settings.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

namespace fracture::cli {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

struct Settings : testing::Test {
  ServeOptions options;
  std::vector<Setting> table = serve_settings(options);
  std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("fracture_settings_" + std::to_string(::getpid()));
  void SetUp() override { std::filesystem::create_directories(folder); }
  void TearDown() override { std::filesystem::remove_all(folder); }

  std::string write(const std::string& name, const std::string& text) {
    std::ofstream(folder / name) << text;
    return (folder / name).string();
  }
  /// The errors of flags and file together.
  std::vector<std::string> configured(const GivenSettings& flags, const std::string& file = "") {
    return configure(options, table, flags, file.empty() ? "" : write("config.toml", file));
  }
};

TEST_F(Settings, TheDefaultsAreConsistent) { EXPECT_THAT(configured({}), IsEmpty()); }

TEST_F(Settings, NamesAreUniqueAndEveryDefaultReadsBackAsItself) {
  std::set<std::string> names;
  for (const Setting& setting : table) {
    EXPECT_TRUE(names.insert(setting.name).second) << setting.name;
    EXPECT_FALSE(setting.doc.empty()) << setting.name;
    EXPECT_FALSE(setting.group.empty()) << setting.name;
    const std::string value = setting.get();
    EXPECT_EQ(setting.set(value), std::nullopt) << setting.name << " " << value;
    EXPECT_EQ(setting.get(), value) << setting.name;
  }
}

TEST_F(Settings, AFlagComesBeforeAVariableAndThatBeforeTheFile) {
  const char* const variables[] = {"FRACTURE_MAX_URI=2000",  "FRACTURE_IDLE=7.5",   "PATH=/bin",
                                   "FRACTURE_TEST_MESHES=x", "FRACTURE_COLOUR=red", nullptr};
  std::vector<std::string> unknown, errors;
  const std::vector<GivenSettings> sources = {
      {{"max-uri", {"1000", "--max-uri"}}},
      from_environment(variables, table, unknown),
      from_file(write("c.toml", "max-uri = 3000\nidle = 8\nmax-body = \"1MiB\"\nall-formats = true\n"), table,
                errors)};
  apply(table, sources, errors);
  EXPECT_THAT(errors, IsEmpty());
  EXPECT_THAT(unknown, ElementsAre("FRACTURE_COLOUR"));
  EXPECT_EQ(options.limits.max_uri, 1000u);
  EXPECT_EQ(options.limits.idle, std::chrono::milliseconds(7500));
  EXPECT_EQ(options.limits.max_body, 1u << 20);
  EXPECT_TRUE(options.all_formats);
}

TEST_F(Settings, ThePrintedFileSaysWhatWasGivenAndReadsBack) {
  GivenSettings given;
  const std::string file =
      write("given.toml", "idle = 1.25\nenable-format = [\"blend\", \"fbx\"]\nmax-uri = 900\n");
  ASSERT_THAT(configure(options, table,
                        {{"max-body", {"16MiB", "--max-body"}},
                         {"all-formats", {"true", "--all-formats"}},
                         {"max-uri", {"1000", "--max-uri"}}},
                        file, &given),
              IsEmpty());
  const std::string printed = to_config_file(table, given);
  ServeOptions other;
  const std::vector<Setting> other_table = serve_settings(other);
  GivenSettings again;
  EXPECT_THAT(configure(other, other_table, {}, write("p.toml", printed), &again), IsEmpty());
  EXPECT_EQ(to_config_file(other_table, again), printed);
  EXPECT_THAT(other.enabled_formats, ElementsAre("blend", "fbx"));
  EXPECT_EQ(other.limits.max_body, 16u << 20);
  EXPECT_EQ(other.limits.max_uri, 1000u);
  EXPECT_EQ(again.size(), given.size());
}

/// Values that come from the machine are only comments, so that the file also starts a server on a smaller
/// machine.
TEST_F(Settings, ThePrintedFileSaysWhatThisMachineHasInCommentsOnly) {
  GivenSettings given;
  ASSERT_THAT(configure(options, table, {{"memory", {"0", "--memory"}}}, "", &given), IsEmpty());
  EXPECT_GT(options.memory, 0u) << "resolved";
  std::istringstream lines(to_config_file(table, given));
  std::vector<std::string> in_force;
  std::size_t said = 0;
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty() && line.front() != '#') in_force.push_back(line);
    said += line.starts_with("# max-working = ") || line.starts_with("# mesh-store = ");
  }
  EXPECT_THAT(in_force, ElementsAre("memory = 0"));
  EXPECT_EQ(said, 2u);
}

TEST_F(Settings, EveryMistakeIsNamedAtOnceWithItsPlace) {
  const auto errors =
      configured({{"max-body", {"12x", "--max-body"}}, {"log-level", {"loud", "--log-level"}}},
                 "idle = -1\ncolour = \"red\"\nmax-uri = 3000\nmax-uri = 3001\n[limits]\nidle = 1\n");
  EXPECT_THAT(
      errors,
      testing::UnorderedElementsAre(
          testing::AllOf(HasSubstr("max-body must be"), HasSubstr("'12x'"), HasSubstr("(--max-body)")),
          testing::AllOf(HasSubstr("log-level must be trace, debug, info, warn, error or off"),
                         HasSubstr("'loud'")),
          testing::AllOf(HasSubstr("idle must be a number of seconds"), HasSubstr("config.toml")),
          HasSubstr("colour is not a setting"), HasSubstr("max-uri must be given once"),
          HasSubstr("limits.idle is not a setting")));
}

TEST_F(Settings, LimitsThatContradictEachOtherAreRefusedTogether) {
  options.limits.max_uri = 20'000;
  options.limits.max_bodies = 1000;
  options.limits.max_connections_per_address = 5000;
  options.limits.deadline = std::chrono::milliseconds(0);
  options.server.admin_port = options.server.port;
  options.enabled_formats = {"docx"};
  options.server.cors_origins = {"https://example.org", "example.org", "https://example.org/path"};
  options.trusted_proxies = {"192.0.2.0/24", "192.0.2.1/24", "2001:db8::/129", "::1"};
  EXPECT_THAT(configured({}),
              testing::UnorderedElementsAre(HasSubstr("max-uri (20,000 bytes) is over max-header (16KiB)"),
                                            HasSubstr("max-body"), HasSubstr("max-connections-per-address"),
                                            HasSubstr("deadline"), HasSubstr("port and admin-port"),
                                            HasSubstr("'docx'"), HasSubstr("'example.org'"),
                                            HasSubstr("'https://example.org/path'"),
                                            HasSubstr("'192.0.2.1/24'"), HasSubstr("'2001:db8::/129'")));
}

TEST_F(Settings, ListeningBeyondThisMachineNeedsTokensOrAnExplicitWord) {
  for (const char* open : {"0.0.0.0", "192.0.2.1", "::", "2001:db8::1"}) {
    options.server.address = open;
    EXPECT_THAT(configured({}),
                ElementsAre(testing::AllOf(HasSubstr("--token-file"), HasSubstr("--insecure-bind"))))
        << open;
  }
  EXPECT_THAT(configured({{"insecure-bind", {"true", "--insecure-bind"}}}), IsEmpty());
  options.insecure_bind = false;
  EXPECT_THAT(configured({{"token-file", {write("tokens", "me 0123456789abcdef\n"), "--token-file"}}}),
              IsEmpty());
  EXPECT_EQ(options.server.tokens.size(), 1u);
  options.token_file.clear();
  for (const char* closed : {"127.0.0.1", "127.1.2.3", "::1"}) {
    options.server.address = closed;
    EXPECT_THAT(configured({}), IsEmpty()) << closed;
  }
  options.server.address = "localhost";
  EXPECT_THAT(configured({}), ElementsAre(HasSubstr("numeric")));
}

TEST_F(Settings, ReadingForeignFilesWithoutASandboxNeedsAnExplicitWord) {
  EXPECT_THAT(configured({}), IsEmpty());
  EXPECT_FALSE(options.sandbox_required) << "on this machine alone";
  options.insecure_bind = true;
  options.server.address = "0.0.0.0";
  EXPECT_THAT(configured({}), IsEmpty());
  EXPECT_TRUE(options.sandbox_required);
  EXPECT_THAT(configured({{"require-sandbox", {"no", "--require-sandbox"}}}), IsEmpty());
  EXPECT_FALSE(options.sandbox_required);
  EXPECT_THAT(configured({{"import-workers", {"0", "--import-workers"}}}),
              ElementsAre(HasSubstr("import-workers")))
      << "nobody else reads files";
}

TEST_F(Settings, TokenFilesAreReadStrictly) {
  const std::pair<const char*, const char*> wrong[] = {
      {"", "contains no token"},
      {"# only a comment\n", "contains no token"},
      {"ana\n", "line 1"},
      {"ana short\n", "at least 16"},
      {"ana 0123456789abcde!\n", "at least 16"},
      {"ana 0123456789abcdef write\n", "read-only"},
      {"ana 0123456789abcdef read-only yes\n", "read-only"},
      {"ana 0123456789abcdef\nana 0123456789abcdeg\n", "line 2"},
      {"ana 0123456789abcdef\nbob 0123456789abcdef\n", "line 2"},
  };
  for (const auto& [text, message] : wrong) {
    const auto tokens = tenants::TokenFile::parse(text);
    ASSERT_FALSE(tokens) << text;
    EXPECT_THAT(tokens.error().detail, HasSubstr(message)) << text;
    EXPECT_THAT(tokens.error().detail, testing::Not(HasSubstr("0123456789")))
        << "a token in an error message";
  }
  EXPECT_EQ(tenants::TokenFile::parse("# studio\nana 0123456789abcdef\n\nbob 0123456789abcdeg read-only\r\n")
                ->size(),
            2u);
  EXPECT_THAT(configured({{"token-file", {"/absent/tokens", ""}}}),
              ElementsAre(HasSubstr("--token-file '/absent/tokens' cannot be read: No such file")));
}

TEST_F(Settings, RedisAndItsSignaturesAreJudgedTogether) {
  EXPECT_THAT(configured({{"redis-user", {"farm", ""}}, {"redis-tls", {"true", ""}}}),
              testing::UnorderedElementsAre(HasSubstr("with --redis"), HasSubstr("redis-user needs")));
  options.service.tiers.redis.address = "/run/redis.sock";
  EXPECT_THAT(configured({}),
              testing::UnorderedElementsAre(HasSubstr("redis-user needs"),
                                            HasSubstr("redis-tls needs a redis address host")));
  options.service.tiers.redis.address = "redis:6379";
  EXPECT_THAT(configured({{"redis-password", {"hunter2", ""}},
                          {"redis-password-file", {"/absent/password", ""}},
                          {"redis-cert-file", {"/absent/cert", ""}},
                          {"sign-disk-cache", {"true", ""}},
                          {"farm-key-file", {write("short", "hunter2\n"), ""}}}),
              testing::UnorderedElementsAre(
                  HasSubstr("both given"), HasSubstr("/absent/password cannot be read"),
                  HasSubstr("must be given together"), HasSubstr("redis-tls: "), HasSubstr("farm-key-file")));
  const std::string printed = to_config_file(table, {}) + to_json(table).dump();
  EXPECT_THAT(printed, testing::Not(HasSubstr("hunter2")));
}

TEST_F(Settings, ThePasswordOfRedisAndTheKeysOfTheFarmComeFromFiles) {
  options.service.tiers.redis.address = "redis:6379";
  EXPECT_THAT(configured({}), IsEmpty());
  EXPECT_THAT(options.warnings, ElementsAre(HasSubstr("--farm-key-file")));
  options.warnings.clear();
  EXPECT_THAT(configured({{"redis-password-file", {write("password", "correct horse\r\nmore\n"), ""}},
                          {"redis-user", {"farm", ""}},
                          {"farm-key-file", {write("keys", std::string(64, 'a') + "\n"), ""}},
                          {"sign-disk-cache", {"true", ""}}}),
              IsEmpty());
  EXPECT_EQ(options.service.tiers.redis.password, "correct horse");
  EXPECT_FALSE(options.service.tiers.keys.empty());
  EXPECT_THAT(options.warnings, IsEmpty());
}

TEST_F(Settings, SecretsAreNotPrinted) {
  std::string password = "hunter2";
  Setting secret = text("password", "TEXT", password, "A secret.");
  secret.secret = true;
  const std::vector<Setting> secrets = {secret};
  EXPECT_THAT(to_config_file(secrets, {{"password", {"hunter2", ""}}}), testing::Not(HasSubstr("hunter2")));
  EXPECT_EQ(to_json(secrets).at("password"), "***");
}

}  // namespace
}  // namespace fracture::cli
