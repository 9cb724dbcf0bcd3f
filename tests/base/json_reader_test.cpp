// Reads JSON from untrusted clients: which documents are refused, and that the counted memory agrees with
// malloc's own figures.
#include "common/base/json_reader.hpp"

#include <gtest/gtest.h>
#include <malloc.h>

namespace fracture {
namespace {

using Kind = JsonFault::Kind;

Kind fault_of(const std::string& text, const JsonLimits& limits = {}) {
  const auto read = read_json(text, limits);
  EXPECT_FALSE(read) << text.substr(0, 100);
  return read ? Kind::kSyntax : read.error().kind;
}

TEST(JsonReader, ReadsWhatTheLibraryReads) {
  for (
      const char* text :
      {"{}", "[]", "17", "-3", "1.5e3", "true", "null", "\"a\\u00e9\"", "[[],[[]],{}]",
       R"({"b": [1, "two", {"a": null}], "a": {"b": {"a": [0.5]}}, "": [[[]]], "long name beyond sixteen": ""})"})
    EXPECT_EQ(read_json(text, {})->value, nlohmann::json::parse(text)) << text;
  EXPECT_EQ(read_json(R"({"b": {"x": 1}, "a": 2})", {})->members, (std::vector<std::string>{"b", "a"}));
}

TEST(JsonReader, RefusesByName) {
  const auto read = read_json(R"({"sites": 1, "seed": 2, "sites": 3})", {});
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().kind, Kind::kRepeated);
  EXPECT_EQ(read.error().name, "sites");
  EXPECT_EQ(to_text(read.error()), "names 'sites' more than once");
  EXPECT_EQ(fault_of(R"({"a": [{"b": 1, "b": 1}]})"), Kind::kRepeated) << "at any depth";
  EXPECT_EQ(fault_of(R"({"\u0061": 1, "a": 1})"), Kind::kRepeated) << "however it is written";
}

TEST(JsonReader, RefusesWhatIsNoJson) {
  for (const char* text : {"", "{", "{]", "[1,]", "{\"a\" 1}", "nul", "1 2", "\"\xff\"", "[1}"})
    EXPECT_EQ(fault_of(text), Kind::kSyntax) << text;
}

TEST(JsonReader, TellsAnEarlyEndFromAnError) {
  for (const char* text : {"", "{", "[1,", "\"a", "{\"a\": "})
    EXPECT_TRUE(read_json(text, {}).error().at_end) << text;
  for (const char* text : {"{]", "[1,]", "{\"a\" 1}", "1 2", "[1}"})
    EXPECT_FALSE(read_json(text, {}).error().at_end) << text;
  EXPECT_EQ(to_text(read_json("{\"a\": ", {}).error()), "ends before its JSON is complete (byte 7)");
}

TEST(JsonReader, RefusesANulAndSaysWhere) {
  const std::string nul(1, '\0');
  for (const std::string& behind :
       {std::string(), std::string("rubbish"), std::string("{\"seed\": 2}"), nul}) {
    const auto read = read_json("{\"seed\": 1}" + nul + behind, {});
    ASSERT_FALSE(read) << behind;
    EXPECT_EQ(read.error().kind, Kind::kSyntax);
    EXPECT_EQ(read.error().byte, 12u) << "the bytes up to it, and itself";
  }
  EXPECT_EQ(fault_of("{\"a\": \"" + nul + "\"}"), Kind::kSyntax) << "in a text, too: it is written \\u0000";
}

TEST(JsonReader, RefusesDepth) {
  EXPECT_TRUE(read_json("[[[1]]]", {.depth = 3}));
  EXPECT_EQ(fault_of("[[[[1]]]]", {.depth = 3}), Kind::kTooDeep);
  EXPECT_EQ(fault_of(std::string(1'000'000, '['), {.depth = 3}), Kind::kTooDeep);
}

std::string repeated(const std::string& part, std::size_t count) {
  std::string text = "[";
  for (std::size_t k = 0; k < count; ++k) text += (k > 0 ? "," : "") + part;
  return text + "]";
}

TEST(JsonReader, HoldsNoMoreThanItMay) {
  constexpr std::size_t kMost = 1u << 20;
  for (const char* part : {"0", "[]", "{}", "{\"\":0}", "\"\"", "\"a text that does not fit in place\""}) {
    const std::string text = repeated(part, 1'000'000);
    const std::size_t before = ::mallinfo2().uordblks + ::mallinfo2().hblkhd;
    const auto read = read_json(text, {.bytes = kMost});
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().kind, Kind::kTooLarge) << part;
    EXPECT_LE(::mallinfo2().uordblks + ::mallinfo2().hblkhd, before + kMost) << part;
  }
}

TEST(JsonReader, CountsWhatAValueHolds) {
#ifdef FRACTURE_SANITIZED
  GTEST_SKIP() << "the sanitizers have an allocator of their own";
#endif
  for (const char* part : {"0", "[]", "{}", "{\"\":0}", "\"\"", "\"a text that does not fit in place\"",
                           "[1,2,3]", "{\"a name that does not fit in place\":[{}]}"}) {
    const std::string text = repeated(part, 100'000);
    const auto used = [] { return ::mallinfo2().uordblks + ::mallinfo2().hblkhd; };
    const std::size_t before = used();
    const auto read = read_json(text, {.bytes = 1u << 30});
    ASSERT_TRUE(read);
    const auto held = static_cast<double>(used() - before),
               counted = static_cast<double>(json_bytes(read->value));
    EXPECT_GT(counted, 0.9 * held) << part;
    EXPECT_LT(counted, 1.1 * held) << part;
  }
}

}  // namespace
}  // namespace fracture
