#include "common/exchange/problem_document.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace fracture::protocol {
namespace {

TEST(ProblemDocument, HasWhatIsTextAndNothingElse) {
  const ProblemDocument problem = problem_in(nlohmann::json{
      {"type", "/problems/bad-parameter"}, {"title", "A title"}, {"detail", 7}, {"parameter", "sites"}});
  EXPECT_EQ(problem.slug(), "bad-parameter");
  EXPECT_EQ(problem.title, "A title");
  EXPECT_EQ(problem.detail, "");
  EXPECT_EQ(problem.parameter, "sites");
  const nlohmann::json figures{{"type", "/problems/a"}, {"title", "A"},         {"status", 422},
                               {"detail", "B."},        {"parameter", "nodes"}, {"instance", "/x"},
                               {"request_id", "1"},     {"known", {"lid"}},     {"open_edges", 3}};
  EXPECT_EQ(*problem_in(figures).extra, (nlohmann::json{{"known", {"lid"}}, {"open_edges", 3}}));
  EXPECT_TRUE(problem_in(nlohmann::json("text")).extra->empty());
  EXPECT_EQ(problem_in(nlohmann::json::array({1})).slug(), "");
  EXPECT_EQ(problem_in(nlohmann::json()).detail, "");
}

TEST(ProblemDocument, OfAnAnswerAlwaysHasADetail) {
  Exchange exchange;
  exchange.status = 502;
  for (const char* body : {"", "<html>Bad gateway</html>", "{", "[]", "{\"title\": \"No\"}"}) {
    exchange.body = body;
    EXPECT_EQ(problem_in(exchange).detail, "The server responded with status 502.") << body;
    EXPECT_EQ(problem_in(exchange).slug(), "") << body;
  }
  exchange.body = R"({"type": "mesh-not-closed", "detail": "It is open."})";
  EXPECT_EQ(problem_in(exchange).slug(), "mesh-not-closed") << "a type without a path";
  EXPECT_EQ(problem_in(exchange).detail, "It is open.");
}

}  // namespace
}  // namespace fracture::protocol
