// How the errors of a bake are classified, printed and reported.
#include "server/bake/failure.hpp"

#include <gtest/gtest.h>

#include "server/http/problem.hpp"

namespace fracture::bake {
namespace {

using nlohmann::json;

protocol::ProblemDocument problem_document(const std::string& type, const std::string& title = "") {
  return {.type = type, .title = title, .detail = "Because.", .parameter = "sites"};
}

TEST(BakeFailure, TheRefusalOfAServerIsTheErrorThatItNames) {
  const Error error = to_error(400, problem_document("/problems/bad-parameter", "Another title"));
  EXPECT_EQ(error.code, ErrorCode::kBadParameter);
  EXPECT_EQ(outcome_of(error.code), Outcome::kRefused);
  EXPECT_EQ(to_problem(error), to_problem(Error{ErrorCode::kBadParameter, "Because.", "sites"}));
  EXPECT_EQ(to_problem(error), (json{{"type", "/problems/bad-parameter"},
                                     {"title", title(ErrorCode::kBadParameter)},
                                     {"detail", "Because."},
                                     {"parameter", "sites"}}));
  EXPECT_EQ(to_line(error), "bad-parameter: Because.");
}

TEST(BakeFailure, WhatNoPipelineSaysKeepsTheWordsOfTheServer) {
  const Error error =
      to_error(413, problem_document("/problems/body-too-large", "The body is over the limit"));
  EXPECT_EQ(error.code, ErrorCode::kRefusedByServer);
  EXPECT_EQ(to_problem(error), (json{{"type", "/problems/body-too-large"},
                                     {"title", "The body is over the limit"},
                                     {"detail", "Because."},
                                     {"parameter", "sites"}}));
  EXPECT_EQ(to_lines(error), "body-too-large: The body is over the limit\n  Because.");
  const Error proxy = to_error(500, {.detail = "The server answered 500."});
  EXPECT_EQ(outcome_of(proxy.code), Outcome::kFailed);
  EXPECT_EQ(to_problem(proxy), (json{{"detail", "The server answered 500."}}));
  EXPECT_EQ(to_lines(proxy), "The server answered 500.");
  EXPECT_EQ(outcome_of(to_error(504, {}).code), Outcome::kRefused) << "a deadline is no bug";
}

TEST(BakeFailure, BugsAreToldFromRefusals) {
  for (const ErrorCode bug : {ErrorCode::kInternal, ErrorCode::kOutOfMemory, ErrorCode::kJobLost})
    EXPECT_EQ(outcome_of(to_error(500, problem_document("/problems/" + std::string(slug(bug)))).code),
              Outcome::kFailed)
        << slug(bug);
  EXPECT_EQ(outcome_of(ErrorCode::kMeshNotClosed), Outcome::kRefused);
  EXPECT_EQ(outcome_of(ErrorCode::kDeadlineExceeded), Outcome::kRefused);
  EXPECT_EQ(outcome_of(ErrorCode::kOverloaded), Outcome::kFailed)
      << "no room on this machine says nothing about the mesh";
  EXPECT_EQ(outcome_of(ErrorCode::kCancelled), Outcome::kCancelled);
  EXPECT_EQ(outcome_of(ErrorCode::kUnavailable), Outcome::kUnavailable);
  EXPECT_EQ(to_lines(Error{ErrorCode::kUnavailable, "Nobody is there."}), "Nobody is there.");
}

TEST(BakeFailure, AnUnsoundAnswerHasItsCertificateAndNobodyElse) {
  const json certificate{{"open_edges", 3}};
  EXPECT_EQ(certificate_of({ErrorCode::kUnsound, "It is open.", {}, Figures(certificate)}), certificate);
  EXPECT_EQ(to_problem({ErrorCode::kUnsound, "It is open.", {}, Figures(certificate)}).at("open_edges"), 3);
  EXPECT_TRUE(certificate_of({ErrorCode::kUnsound, "It is open."}).is_null());
  EXPECT_TRUE(certificate_of({ErrorCode::kMeshNotClosed, "It is open.", {}, Figures(certificate)}).is_null());
}

/// The server's problem document for `error`, without the members that belong to an HTTP exchange.
json by_server(const Error& error) {
  json document = json::parse(http::to_problem(error).body("id"));
  document.erase("status");
  document.erase("request_id");
  return document;
}

TEST(BakeFailure, AReportSaysOfEveryErrorWhatAServersAnswerSays) {
  const Figures extra(json{{"known", {"lid", "body"}},
                           {"errors", json::array({{{"parameter", "sites"}, {"detail", "Because."}}})},
                           {"open_edges", 3},
                           {"sample", {0.5, 1, 2}},
                           {"title", "none of the figures"},
                           {"status", 1},
                           {"request_id", "none"}});
  std::size_t compared = 0;
  for (const http::ProblemType& type : http::problem_types()) {
    const std::optional<ErrorCode> code = error_code(type.slug);
    // An overloaded server and an internal error add members: when to retry, and what to report.
    if (!code || *code == ErrorCode::kOverloaded || *code == ErrorCode::kInternal) continue;
    for (const Error& error : {Error{*code, "Because.", "sites", extra}, Error{*code, "Because."}}) {
      EXPECT_EQ(to_problem(error), by_server(error)) << type.slug;
      ++compared;
    }
    const Error error{*code, "Because.", "sites", extra};
    const json answer = json::parse(http::to_problem(error).body("id"));
    EXPECT_EQ(to_problem(to_error(type.status, protocol::problem_in(answer))), by_server(error))
        << type.slug << " through a server";
  }
  EXPECT_GT(compared, 40u);
}

TEST(BakeFailure, EverythingThatIsWrongIsSaidInALineOfItsOwn) {
  const json errors = json::array({{{"detail", "First."}}, {{"detail", "Second."}}});
  const Error error{ErrorCode::kBadParameter, "First.", "sites", Figures(json{{"errors", errors}})};
  EXPECT_EQ(to_lines(error), std::string("bad-parameter: ") + title(error.code) + "\n  First.\n  Second.");
  EXPECT_EQ(to_problem(error).at("errors"), errors);
}

TEST(BakeFailure, TheNamesThatAMessageRefersToAreShown) {
  const Error error{ErrorCode::kBadParameter, "The member 'known' lists the names.", "nodes",
                    Figures(json{{"known", {"lid", "body"}}})};
  EXPECT_EQ(to_lines(error), std::string("bad-parameter: ") + title(error.code) +
                                 "\n  The member 'known' lists the names.\n  known: lid, body");
}

}  // namespace
}  // namespace fracture::bake
