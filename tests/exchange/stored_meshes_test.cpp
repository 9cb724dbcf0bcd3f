#include "common/exchange/stored_meshes.hpp"

#include <gtest/gtest.h>

#include "common/exchange/backoff.hpp"

namespace fracture::protocol {
namespace {

using Role = PutOnce::Role;

TEST(StoredMeshes, AreAddressedByTheDigestOfTheirBytes) {
  // The SHA-256 of the empty message, by FIPS 180-4.
  const std::string id = mesh_id("");
  EXPECT_EQ(id, "sha256:e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  const HttpRequest put = put_request(id, "model/obj", std::make_shared<const std::string>("bytes"));
  EXPECT_STREQ(put.method, "PUT");
  EXPECT_EQ(put.target, "/meshes/" + id);
  EXPECT_EQ(put.content_type, "model/obj");
  EXPECT_EQ(*put.body, "bytes");
  const HttpRequest ask = fracture_request(id, "{}");
  EXPECT_STREQ(ask.method, "POST");
  EXPECT_EQ(ask.target, "/meshes/" + id + "/fracture");
  EXPECT_EQ(ask.content_type, "application/json");
  EXPECT_EQ(*ask.body, "{}");
}

TEST(StoredMeshes, AreMissingWhereTheServerItselfSaysSo) {
  EXPECT_TRUE(mesh_is_missing(404, "not-found"));
  EXPECT_FALSE(mesh_is_missing(404, "")) << "a proxy";
  EXPECT_FALSE(mesh_is_missing(404, "no-such-answer"));
  EXPECT_FALSE(mesh_is_missing(410, "not-found"));
}

TEST(PutOnce, OneOfAllWhoMissAMeshPutsIt) {
  PutOnce puts;
  const auto sent = PutOnce::Clock::now();
  EXPECT_EQ(puts.begin("a", sent), Role::kPut);
  EXPECT_EQ(puts.begin("a", sent), Role::kWait);
  EXPECT_TRUE(puts.pending("a"));
  EXPECT_EQ(puts.begin("b", sent), Role::kPut) << "another mesh";
  puts.done("a", true);
  EXPECT_FALSE(puts.pending("a"));
  EXPECT_EQ(puts.begin("a", sent), Role::kRetry) << "its answer was on its way while the mesh was put";
  EXPECT_FALSE(puts.pending("a"));
}

TEST(PutOnce, AMeshThatIsMissingAgainIsPutAgain) {
  PutOnce puts;
  const auto sent = PutOnce::Clock::now();
  EXPECT_EQ(puts.begin("a", sent), Role::kPut);
  puts.done("a", false);
  EXPECT_EQ(puts.begin("a", sent), Role::kPut) << "the first one failed";
  puts.done("a", true);
  EXPECT_EQ(puts.begin("a", PutOnce::Clock::now() + std::chrono::seconds(1)), Role::kPut)
      << "forgotten since";
}

TEST(Backoff, DoublesUpToTheLongest) {
  Backoff backoff(Milliseconds(50), Milliseconds(300));
  for (const int expected : {50, 100, 200, 300, 300}) {
    EXPECT_EQ(backoff.pause(), Milliseconds(expected));
    backoff.lengthen();
  }
}

}  // namespace
}  // namespace fracture::protocol
