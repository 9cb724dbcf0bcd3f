#include "server/http/request_head.hpp"

#include <gtest/gtest.h>

#include "server/http/accept.hpp"
#include "server/http/multipart.hpp"

namespace fracture::http {
namespace {

OrProblem<RequestHead> parse(const std::string& text) { return parse_head(text, HttpLimits{}); }

int status_of(const std::string& text) {
  std::size_t searched = 0;
  const auto end = find_head_end(text, searched, HttpLimits{});
  if (!end) return end.error().type->status;
  if (!*end) return 0;
  const auto head = parse(text.substr(0, **end));
  return head ? 200 : head.error().type->status;
}

TEST(RequestHead, ReadsAnOrdinaryRequest) {
  const auto head = parse(
      "POST /fracture?sites=5&dual=a%20b HTTP/1.1\r\nHost: a:80\r\nContent-Length: 12\r\nX-A:  v \t\r\n\r\n");
  ASSERT_TRUE(head);
  EXPECT_EQ(head->method, "POST");
  EXPECT_EQ(head->path, "/fracture");
  EXPECT_EQ(head->content_length, 12u);
  EXPECT_FALSE(head->chunked);
  EXPECT_TRUE(head->keep_alive);
  EXPECT_EQ(head->field("x-a"), "v");
  const auto query = parse_query(head->query);
  ASSERT_TRUE(query);
  EXPECT_EQ((*query)[1], (std::pair<std::string, std::string>("dual", "a b")));
}

TEST(RequestHead, AnythingAboutFramingThatTwoParsersCouldReadDifferentlyIsRefused) {
  const std::string line = "POST / HTTP/1.1\r\n", host = "Host: a\r\n", end = "\r\n";
  const struct {
    const char* fields;
    int status;
  } cases[] = {
      {"Transfer-Encoding: chunked\r\n", 200},
      {"transfer-encoding: CHUNKED\r\n", 200},
      {"Transfer-Encoding: xchunked\r\n", 501},
      {"Transfer-Encoding: gzip\r\n", 501},
      {"Transfer-Encoding: chunked, identity\r\n", 501},
      {"Transfer-Encoding: gzip, chunked\r\n", 501},
      {"Transfer-Encoding: chunked, chunked\r\n", 501},
      {"Transfer-Encoding: \"chunked\"\r\n", 501},
      {"Transfer-Encoding: chunked;q=1\r\n", 501},
      {"Transfer-Encoding:\r\n", 501},
      {"Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n", 501},
      {"Transfer-Encoding: chunked\r\nTransfer-Encoding: identity\r\n", 501},
      {"Transfer-Encoding : chunked\r\n", 400},
      {"Transfer-Encoding\t: chunked\r\n", 400},
      {" Transfer-Encoding: chunked\r\n", 400},
      {"Transfer-Encoding: chun\r\n ked\r\n", 400},
      {"Transfer-Encoding: \x0b"
       "chunked\r\n",
       400},
      {"Transfer-Encoding: chunked\x0c\r\n", 400},
      {"Transfer-Encoding: chunked\r\nContent-Length: 5\r\n", 400},
      {"Content-Length: 5\r\nTransfer-Encoding: chunked\r\n", 400},
      {"Content-Length: 0\r\nTransfer-Encoding: xchunked\r\n", 400},
      {"Content-Length: 5\r\n", 200},
      {"Content-Length: 5\r\nContent-Length: 5\r\n", 400},
      {"Content-Length: 5\r\nContent-Length: 6\r\n", 400},
      {"Content-Length: 5, 5\r\n", 400},
      {"Content-Length: +5\r\n", 400},
      {"Content-Length: -5\r\n", 400},
      {"Content-Length: 0x5\r\n", 400},
      {"Content-Length: 5 5\r\n", 400},
      {"Content-Length: \r\n", 400},
      {"Content-Length: 5.0\r\n", 400},
      {"Content-Length : 5\r\n", 400},
      {"Content_Length: 5\r\n", 200},  // another field, which the server does not read
      {"Host: b\r\n", 400},
      {"X: a\nTransfer-Encoding: chunked\r\n", 400},
      {"X: a\rTransfer-Encoding: chunked\r\n", 400},
      {"X: a\x01\r\n", 400},
      {"X: a\x7f\r\n", 400},
      {"X\x80: a\r\n", 400},
      {"X Y: a\r\n", 400},
      {": a\r\n", 400},
      {"no colon\r\n", 400},
      {"Expect: 200-ok\r\n", 417},
      {"Expect: 100-continue\r\n", 200},
  };
  for (const auto& c : cases) EXPECT_EQ(status_of(line + host + c.fields + end), c.status) << c.fields;
  EXPECT_EQ(status_of(line + end), 400) << "no Host";
  EXPECT_EQ(status_of("GET / HTTP/1.0\r\n\r\n"), 200) << "HTTP/1.0 needs no Host";
  EXPECT_EQ(status_of("POST / HTTP/1.0\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\n"), 400);
  EXPECT_EQ(status_of(std::string("GET / HTTP/1.1\r\nHost: a\r\nX: ") + '\0' + "\r\n\r\n"), 400) << "NUL";
}

TEST(RequestHead, OnlyOneFormOfRequestLineIsRead) {
  const struct {
    const char* line;
    int status;
  } cases[] = {
      {"GET / HTTP/1.1", 200},         {"GET http://a/ HTTP/1.1", 400},
      {"GET * HTTP/1.1", 400},         {"CONNECT a:80 HTTP/1.1", 400},
      {"GET  / HTTP/1.1", 400},        {"GET /a b HTTP/1.1", 400},
      {"GET /\ta HTTP/1.1", 400},      {"GET /a#b HTTP/1.1", 400},
      {"GET /%zz HTTP/1.1", 400},      {"GET /%00 HTTP/1.1", 400},
      {"GET /\xc3\xa4 HTTP/1.1", 400}, {" GET / HTTP/1.1", 400},
      {"G(T / HTTP/1.1", 400},         {"GET /", 400},
      {"GET / HTTP/1.1 ", 400},        {"GET / http/1.1", 400},
      {"GET / HTTP/1,1", 400},         {"GET / HTTP/01.1", 400},
      {"GET / HTTP/2.0", 505},         {"GET / HTTP/1.2", 505},
      {"GET / HTTP/0.9", 505},
  };
  for (const auto& c : cases)
    EXPECT_EQ(status_of(std::string(c.line) + "\r\nHost: a\r\n\r\n"), c.status) << c.line;
  EXPECT_EQ(status_of("\r\nGET / HTTP/1.1\r\nHost: a\r\n\r\n"), 400);
  EXPECT_EQ(status_of("\nGET / HTTP/1.1\r\nHost: a\r\n\r\n"), 400);
}

TEST(RequestHead, AMalformedHeaderIsKnownBeforeItIsComplete) {
  std::size_t searched = 0;
  EXPECT_FALSE(find_head_end("GET / HTTP/1.1\nHost", searched, HttpLimits{}));
  searched = 0;
  EXPECT_FALSE(find_head_end("GET / HTTP/1.1\rX", searched, HttpLimits{}));
}

TEST(RequestHead, TheEndIsFoundHoweverTheBytesArrive) {
  const std::string text = "GET / HTTP/1.1\r\nHost: a\r\n\r\n";
  std::size_t searched = 0;
  for (std::size_t n = 0; n < text.size(); ++n) {
    const auto end = find_head_end(std::string_view(text).substr(0, n), searched, HttpLimits{});
    ASSERT_TRUE(end) << n;
    EXPECT_FALSE(*end) << n;
  }
  EXPECT_EQ(**find_head_end(text + "body", searched, HttpLimits{}), text.size());
}

TEST(RequestHead, LimitsHaveTheirOwnStatus) {
  HttpLimits limits;
  EXPECT_EQ(status_of("GET /" + std::string(limits.max_uri, 'a') + " HTTP/1.1\r\nHost: a\r\n\r\n"), 414);
  EXPECT_EQ(status_of("GET /" + std::string(limits.max_header, 'a')), 414);
  EXPECT_EQ(status_of("GET / HTTP/1.1\r\nHost: a\r\nX: " + std::string(limits.max_header, 'a')), 431);
}

// The work for each field and each of its members is bounded by limits on their number, however short they
// are.
TEST(RequestHead, FieldsAndTheirMembersAreFew) {
  const auto repeated = [](const std::string& text, std::size_t count) {
    std::string all;
    while (count-- > 0) all += text;
    return all;
  };
  const std::string begin = "GET / HTTP/1.1\r\nHost: a\r\n", end = "\r\n";
  EXPECT_EQ(status_of(begin + repeated("a:\r\n", kMaxFields - 1) + end), 200) << "and the Host";
  EXPECT_EQ(status_of(begin + repeated("a:\r\n", kMaxFields) + end), 431);
  for (const std::string separator : {",", ";"}) {
    EXPECT_EQ(status_of(begin + "Accept: " + repeated(separator, kMaxMembers) + "\r\n" + end), 200);
    EXPECT_EQ(status_of(begin + "Accept: " + repeated(separator, kMaxMembers + 1) + "\r\n" + end), 431);
  }
  const std::string one = "Prefer: " + repeated("a,", kMaxMembers / 2) + "\r\n";
  EXPECT_EQ(status_of(begin + one + one + end), 200);
  EXPECT_EQ(status_of(begin + one + one + "Accept: a;q=1\r\n" + end), 431) << "all fields together";
}

TEST(RequestHead, ConnectionCloseIsFoundInAnyListAndHttp10AlwaysCloses) {
  EXPECT_FALSE(parse("GET / HTTP/1.1\r\nHost: a\r\nConnection: x, CLOSE ,y\r\n\r\n")->keep_alive);
  EXPECT_TRUE(parse("GET / HTTP/1.1\r\nHost: a\r\nConnection: closed\r\n\r\n")->keep_alive);
  EXPECT_FALSE(parse("GET / HTTP/1.0\r\nConnection: keep-alive\r\n\r\n")->keep_alive);
}

TEST(Query, MalformedEscapesAreNotGuessedAt) {
  EXPECT_FALSE(parse_query("a=%"));
  EXPECT_FALSE(parse_query("a=%4"));
  EXPECT_FALSE(parse_query("%zz=1"));
  EXPECT_EQ(parse_query("&&a&b=+%2B&")->size(), 2u);
  EXPECT_EQ((*parse_query("b=+%2B"))[0].second, " +");
}

// -- Accept

TEST(Accept, TheBestQualityWinsAndTiesGoToTheFirstOffer) {
  constexpr std::string_view offers[] = {"model/gltf-binary", "application/json"};
  EXPECT_EQ(negotiate("", offers), 0u);
  EXPECT_EQ(negotiate("*/*", offers), 0u);
  EXPECT_EQ(negotiate("application/json", offers), 1u);
  EXPECT_EQ(negotiate("Application/JSON, model/*;q=0.5", offers), 1u);
  EXPECT_EQ(negotiate("application/json;q=0.5, */*;q=0.6", offers), 0u);
  EXPECT_EQ(negotiate("*/*, model/gltf-binary;q=0", offers), 1u) << "a specific refusal beats the wildcard";
  EXPECT_EQ(negotiate("image/png", offers), std::nullopt);
  EXPECT_EQ(negotiate("*/*;q=0", offers), std::nullopt);
  EXPECT_EQ(negotiate("application/json;q=2", offers), std::nullopt) << "malformed quality";
  EXPECT_EQ(negotiate(",,;;,", offers), std::nullopt);
}

TEST(Accept, AFileOfAnyTypeMatchesEachRange) {
  constexpr std::string_view offers[] = {"*/*"};
  for (const char* accept : {"", "*/*", "application/json", "image/*", "text/html;q=0, application/json"})
    EXPECT_EQ(negotiate(accept, offers), 0u) << accept;
  EXPECT_EQ(negotiate("*/*;q=0", offers), std::nullopt);
  EXPECT_EQ(negotiate("json", offers), std::nullopt);
}

// -- multipart

const std::string kForm =
    "--B\r\nContent-Disposition: form-data; name=\"mesh\"; filename=\"a \\\"b\\\".glb\"\r\n"
    "Content-Type: Model/gltf-binary; x=y\r\n\r\nbytes\r\n--not"
    "\r\n--B\r\nContent-Disposition: form-data; name=params\r\n\r\n{}\r\n--B--\r\n";

TEST(Multipart, PartsAreViewsOfTheBodyWithNameFileAndType) {
  const auto parts = parse_multipart(kForm, "B");
  ASSERT_TRUE(parts) << parts.error().detail;
  ASSERT_EQ(parts->size(), 2u);
  EXPECT_EQ((*parts)[0].name, "mesh");
  EXPECT_EQ((*parts)[0].filename, "a \"b\".glb");
  EXPECT_EQ((*parts)[0].content_type, "model/gltf-binary");
  EXPECT_EQ((*parts)[1].body, "{}");
}

TEST(Multipart, ABoundaryInsideTheMeshThatIsNoBoundaryLineIsRefused) {
  // "\r\n--Bnot" begins like a delimiter. RFC 2046 forbids that inside a part, so the body is damaged.
  EXPECT_FALSE(
      parse_multipart("--B\r\nContent-Disposition: form-data; name=m\r\n\r\nx\r\n--Bnot\r\n--B--", "B"));
}

TEST(Multipart, EveryTruncationIsRefusedAndNoneReadsPastTheEnd) {
  const std::string whole = "--B\r\nContent-Disposition: form-data; name=m\r\n\r\nx\r\n--B--";
  ASSERT_TRUE(parse_multipart(whole, "B"));
  for (std::size_t n = 0; n < whole.size(); ++n) {
    const std::string cut(whole, 0, n);  // a separate copy, so that ASan sees where it ends
    EXPECT_FALSE(parse_multipart(cut, "B")) << n;
  }
}

TEST(Multipart, BoundariesComeFromTheContentType) {
  EXPECT_EQ(multipart_boundary("multipart/form-data; boundary=abc"), "abc");
  EXPECT_EQ(multipart_boundary("Multipart/Form-Data; charset=x; Boundary=\"a b\""), "a b");
  for (const char* bad :
       {"multipart/form-data", "multipart/form-data; boundary=", "multipart/mixed; boundary=a",
        "multipart/form-data; boundary=\"unclosed", "multipart/form-data; boundary"})
    EXPECT_FALSE(multipart_boundary(bad)) << bad;
  EXPECT_FALSE(multipart_boundary("multipart/form-data; boundary=" + std::string(71, 'b')));
}

TEST(Multipart, PartsAndTheirHeadersAreBounded) {
  std::string many;
  for (std::size_t i = 0; i <= kMaxParts; ++i)
    many += "--B\r\nContent-Disposition: form-data; name=x\r\n\r\n\r\n";
  EXPECT_FALSE(parse_multipart(many + "--B--", "B"));
  EXPECT_FALSE(parse_multipart(
      "--B\r\nContent-Disposition: form-data; name=" + std::string(kMaxPartHeader, 'x') + "\r\n\r\n\r\n--B--",
      "B"));
}

}  // namespace
}  // namespace fracture::http
