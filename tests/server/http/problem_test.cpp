// How errors are sent over HTTP.
#include "server/http/problem.hpp"

#include <gtest/gtest.h>

namespace fracture::http {
namespace {

using nlohmann::json;
using Fields = std::vector<std::pair<std::string, std::string>>;

TEST(ToProblem, NoRoomSaysWhenToComeBack) {
  using std::chrono::seconds;
  const Problem full =
      to_problem({.code = ErrorCode::kOverloaded, .detail = "The queue is full.", .retry_after = seconds(7)});
  EXPECT_EQ(full.type->status, 503);
  EXPECT_EQ(full.detail, "The queue is full. Try again after Retry-After.");
  EXPECT_EQ(full.headers, (Fields{{"Retry-After", "7"}}));
  const Problem over = to_problem(
      {.code = ErrorCode::kOverShare, .detail = "It is over its share.", .retry_after = seconds(1)});
  EXPECT_EQ(over.type->status, 429);
  EXPECT_EQ(over.detail, "It is over its share.");
  EXPECT_EQ(over.headers, (Fields{{"Retry-After", "1"}}));
  EXPECT_EQ(to_problem({ErrorCode::kOutOfMemory, "None is left."}).headers, (Fields{{"Retry-After", "10"}}));
}

TEST(ToProblem, KeepsDetailParameterAndFigures) {
  const Problem problem = to_problem({ErrorCode::kBadParameter, "Too many.", "sites",
                                      Figures(nlohmann::json{{"limit", 3}, {"status", "not this one"}})});
  EXPECT_TRUE(problem.headers.empty());
  EXPECT_EQ(json::parse(problem.body("an-id")), (json{{"type", "/problems/bad-parameter"},
                                                      {"title", title(ErrorCode::kBadParameter)},
                                                      {"status", 400},
                                                      {"detail", "Too many."},
                                                      {"parameter", "sites"},
                                                      {"request_id", "an-id"},
                                                      {"limit", 3}}));
}

TEST(ToProblem, ABugIsNotDescribedToStrangers) {
  const Problem bug = to_problem({ErrorCode::kInternal, "secret.cpp:7 broke"});
  EXPECT_EQ(bug.type->status, 500);
  EXPECT_EQ(bug.detail.find("secret"), std::string::npos);
}

TEST(ToProblem, WhatIsOfTheOtherSideIsABugHere) {
#define FRACTURE_ERROR(name, slug, title)
#define FRACTURE_LOCAL_ERROR(name, its_slug, title) \
  EXPECT_EQ(problem_type(ErrorCode::name).slug, "internal") << (its_slug);
#include "common/base/error_codes.def"
#undef FRACTURE_ERROR
}

}  // namespace
}  // namespace fracture::http
