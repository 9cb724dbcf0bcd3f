// The record of a job is checked like a request, because a stranger may have written to the folder.
#include "server/jobs/job_record.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "common/digest/digest.hpp"

namespace fracture {
namespace {

using nlohmann::json;

/// A record with a correct checksum.
std::string signed_text(const std::string& text) {
  return "fracture job 1\n" + sha256(text).hex() + "\n" + text;
}

struct Record : testing::Test {
  const json good = {
      {"id", "0123456789abcdef-0123456789abcdef"},
      {"owner", "ana"},
      {"client", "address 192.0.2.7"},
      {"state", "failed"},
      {"created", 1'764'000'000'000'000},
      {"finished", 1'764'000'001'000'000},
      {"patience_ms", 1'800'000},
      {"digest", std::string(64, 'a')},
      {"mesh_bytes", 150},
      {"format", "obj"},
      {"output", "glb"},
      {"triangles", 12},
      {"result", std::string(64, 'b')},
      {"parameters", {{"sites", 5}}},
      {"error", {{"code", "internal"}, {"detail", "x"}, {"pointer", ""}, {"extra", json::object()}}}};

  bool accepts(const std::function<void(json&)>& change) const {
    json changed = good;
    change(changed);
    return decode_record(signed_text(changed.dump() + "\n")).has_value();
  }
};

TEST_F(Record, WhatTheServerWritesIsAccepted) {
  const auto record = decode_record(signed_text(good.dump()));
  ASSERT_TRUE(record);
  EXPECT_EQ(record->state, JobState::kFailed);
  EXPECT_EQ(record->client, "address 192.0.2.7");
  EXPECT_EQ(record->parameters, good.at("parameters"));
  const auto again = decode_record(encode_record(*record));
  ASSERT_TRUE(again);
  EXPECT_EQ(encode_record(*again), encode_record(*record));
}

/// Algorithm 27 and earlier do not store the client.
TEST_F(Record, ARecordOfAnEarlierReleaseNamesNoClient) {
  json earlier = good;
  earlier.erase("client");
  const auto record = decode_record(signed_text(earlier.dump() + "\n"));
  ASSERT_TRUE(record);
  EXPECT_EQ(record->client, "");
  EXPECT_EQ(encode_record(*record).find("client"), std::string::npos);
}

TEST_F(Record, ParametersNestedTwoHundredThousandDeepAreRefused) {
  const std::string members = good.dump().substr(1);
  std::string deep =
      "{\"parameters\":{\"x\":" + std::string(200'000, '[') + std::string(200'000, ']') + "}," + members;
  EXPECT_FALSE(decode_record(signed_text(deep)));
  deep = good.dump();
  deep.pop_back();
  deep += ",\"more\":" + std::string(200'000, '[') + std::string(200'000, ']') + "}";
  EXPECT_FALSE(decode_record(signed_text(deep)));
}

TEST_F(Record, NumbersOutsideOfWhatTheServerComputesWithAreRefused) {
  const json huge[] = {json(INT64_MAX), json(INT64_MIN), json(UINT64_MAX), json(std::uint64_t{1} << 63),
                       json(-1),        json(1.5),       json("1"),        json(),
                       json::array()};
  for (const char* name : {"created", "finished", "patience_ms", "mesh_bytes", "triangles"})
    for (const json& number : huge)
      EXPECT_FALSE(accepts([&](json& j) { j[name] = number; })) << name << " " << number.dump();
  EXPECT_FALSE(accepts([](json& j) { j["patience_ms"] = 0; }));
  EXPECT_TRUE(accepts([](json& j) { j["created"] = 0; }));
}

TEST_F(Record, EveryMemberHasItsType) {
  for (const auto& [name, value] : good.items()) {
    EXPECT_FALSE(accepts([&name = name](json& j) { j[name] = json::array({1}); })) << name;
    EXPECT_EQ(accepts([&name = name](json& j) { j.erase(name); }),
              name == "finished" || name == "error" || name == "client")
        << name;
  }
  for (const auto& [name, value] : good.at("error").items())
    EXPECT_FALSE(accepts([&name = name](json& j) { j["error"][name] = 5; })) << name;
}

TEST_F(Record, TextsAreOfTheirKindAndLength) {
  EXPECT_FALSE(accepts([](json& j) { j["id"] = "../../etc/passwd"; }));
  EXPECT_FALSE(accepts([](json& j) { j["digest"] = std::string(64, 'x'); }));
  EXPECT_FALSE(accepts([](json& j) { j["result"] = std::string(64, '/'); }));
  EXPECT_FALSE(accepts([](json& j) { j["state"] = "lost"; }));
  EXPECT_FALSE(accepts([](json& j) { j["format"] = "exe"; }));
  EXPECT_FALSE(accepts([](json& j) { j["output"] = "obj"; }));
  EXPECT_FALSE(accepts([](json& j) { j["owner"] = std::string(1u << 20, 'a'); }));
  EXPECT_FALSE(accepts([](json& j) { j["client"] = ""; }));
  EXPECT_FALSE(accepts([](json& j) { j["client"] = std::string(1025, 'a'); }));
  EXPECT_TRUE(accepts([](json& j) { j["client"] = std::string(1024, 'a'); }));
  EXPECT_FALSE(accepts([](json& j) { j["error"]["detail"] = std::string(1u << 20, 'a'); }));
}

TEST_F(Record, ParametersAreSuchAsARequestMayHave) {
  for (const json& forged :
       {json{{"sites", "x"}}, json{{"no_such_parameter", 1}}, json{{"sites", 4'000'000'000u}},
        json{{"local_point", 5}}, json(), json("glass")})
    EXPECT_FALSE(accepts([&](json& j) { j["parameters"] = forged; })) << forged.dump();
  json many = json::array();
  for (int k = 0; k < 200'000; ++k) many.push_back(json::object());
  EXPECT_FALSE(accepts([&](json& j) { j["parameters"]["points"] = many; }));
}

TEST_F(Record, AMemberGivenTwiceIsRefused) {
  EXPECT_FALSE(decode_record(signed_text("{\"owner\": \"bob\"," + good.dump().substr(1))));
}

}  // namespace
}  // namespace fracture
