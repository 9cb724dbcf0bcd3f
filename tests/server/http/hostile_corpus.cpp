#include "tests/server/http/hostile_corpus.hpp"

#include <algorithm>
#include <optional>

namespace fracture::test {
namespace {

using Corpus = std::vector<HostileRequest>;

const std::string kFields = "Host: a\r\nContent-Type: model/obj\r\n";
const std::string kPost = "POST /fracture HTTP/1.1\r\n" + kFields;
const std::string kChunks = "4\r\nmesh\r\n0\r\n\r\n";

/// Every pair of a Transfer-Encoding and a Content-Length, in both orders and both protocol versions. The
/// expected results follow RFC 9112, section 6. If it leaves a choice, the stricter result is expected.
void add_framing_pairs(Corpus& corpus) {
  struct Coding {
    const char* value;
    enum { kChunked, kOther, kMalformed } kind;
  };
  const Coding codings[] = {{"chunked", Coding::kChunked},
                            {"Chunked", Coding::kChunked},
                            {"\tchunked \t", Coding::kChunked},
                            {"xchunked", Coding::kOther},
                            {"gzip", Coding::kOther},
                            {"identity", Coding::kOther},
                            {"chunked, identity", Coding::kOther},
                            {"identity, chunked", Coding::kOther},
                            {"chunked, chunked", Coding::kOther},
                            {"chunked;x=y", Coding::kOther},
                            {"\"chunked\"", Coding::kOther},
                            {"chunked,", Coding::kOther},
                            {"", Coding::kOther},
                            {"\x0b"
                             "chunked",
                             Coding::kMalformed},
                            {"chunked\x01", Coding::kMalformed},
                            {"\x7f"
                             "chunked",
                             Coding::kMalformed}};
  struct Length {
    const char* value;
    int status;  ///< 0: the body has 4 bytes
  };
  const Length lengths[] = {{"4", 0},
                            {"04", 0},
                            {"4\t", 0},
                            {"0", 400},
                            {"+4", 400},
                            {"-4", 400},
                            {"0x4", 400},
                            {"4_", 400},
                            {"4,4", 400},
                            {"4, 61", 400},
                            {"4 4", 400},
                            {"", 400},
                            {"18446744073709551616", 413},
                            {"99999999999999999999999", 413}};
  const auto line = [](const char* name, const char* value) {
    return std::string(name) + ": " + value + "\r\n";
  };
  for (const char* version : {"1.1", "1.0"}) {
    const bool old = std::string(version) == "1.0";
    const std::string begin = "POST /fracture HTTP/" + std::string(version) + "\r\n" + kFields;
    for (const Coding& coding : codings) {
      const std::string te = line("Transfer-Encoding", coding.value);
      const bool good = coding.kind == Coding::kChunked && !old;
      corpus.push_back({"HTTP/" + std::string(version) + " TE '" + coding.value + "'",
                        begin + te + "\r\n" + kChunks,
                        good                                       ? 200
                        : coding.kind == Coding::kMalformed || old ? 400
                                                                   : 501,
                        good});
      for (const Length& length : lengths) {
        if (old && &length != lengths) continue;
        const std::string cl = line("Content-Length", length.value);
        for (const bool first : {true, false})
          corpus.push_back({"HTTP/" + std::string(version) + (first ? " TE '" : " CL before TE '") +
                                coding.value + "' CL '" + length.value + "'",
                            begin + (first ? te + cl : cl + te) + "\r\n" + kChunks, 400});
      }
    }
    for (const Length& length : lengths)  // the connection ends with the answer
      corpus.push_back({"HTTP/" + std::string(version) + " CL '" + length.value + "'",
                        begin + line("Content-Length", length.value) + "\r\nmesh",
                        length.status == 0 ? 200 : length.status, length.status == 0 && !old});
  }
  const std::string two = "Transfer-Encoding: chunked\r\nTransfer-Encoding: ";
  corpus.push_back({"TE twice", kPost + two + "chunked\r\n\r\n" + kChunks, 501});
  corpus.push_back({"TE and another TE", kPost + two + "x\r\n\r\n" + kChunks, 501});
  corpus.push_back({"CL twice, equal", kPost + "Content-Length: 4\r\nContent-Length: 4\r\n\r\nmesh", 400});
  corpus.push_back({"CL twice, different", kPost + "Content-Length: 0\r\nContent-Length: 61\r\n\r\n", 400});
  corpus.push_back({"no framing of a POST", kPost + "\r\n", 400});
}

void add_field_syntax(Corpus& corpus) {
  const std::string body = "Content-Length: 4\r\n\r\nmesh",
                    te = "Transfer-Encoding: chunked\r\n\r\n" + kChunks;
  const auto add = [&corpus](const char* name, const std::string& bytes, int status = 400) {
    corpus.push_back({name, bytes, status});
  };
  add("folded CL", kPost + "Content-Length:\r\n 4\r\n\r\nmesh");
  add("folded TE", kPost + "X: a\r\n Transfer-Encoding: chunked\r\n\r\n" + kChunks);
  add("fold with a tab", kPost + "X: a\r\n\tb\r\n" + body);
  add("fold before the first field", "POST /fracture HTTP/1.1\r\n Host: a\r\n" + body);
  add("space before the colon of CL", kPost + "Content-Length : 4\r\n\r\nmesh");
  add("space before the colon of TE", kPost + "Transfer-Encoding : chunked\r\n\r\n" + kChunks);
  add("tab before the colon", kPost + "Transfer-Encoding\t: chunked\r\n\r\n" + kChunks);
  add("no colon", kPost + "Transfer-Encoding chunked\r\n" + body);
  add("no name", kPost + ": x\r\n" + body);
  for (const char c : std::string("\x01\x08\x0b\x0c\x1f\x7f\x80\xff ()/@[]{}\"\0", 19))
    add("control or separator in a name", kPost + "X" + std::string(1, c) + "Y: 1\r\n" + body);
  for (const char c : std::string("\x01\x08\x0b\x0c\x1b\x7f", 6))
    add("control in a value", kPost + "X: a" + std::string(1, c) + "b\r\n" + body);
  add("NUL in a name", kPost + std::string("X\0: 1\r\n", 7) + body);
  add("NUL in a value", kPost + std::string("X: \0\r\n", 6) + body);
  add("control before TE", kPost + "\x0bTransfer-Encoding: chunked\r\n\r\n" + kChunks);
  add("NUL before TE", kPost + std::string("\0", 1) + te);
  add("bare LF ends a field", kPost + "X: a\nTransfer-Encoding: chunked\r\n\r\n" + kChunks);
  add("bare LF everywhere", "POST /fracture HTTP/1.1\nHost: a\nContent-Length: 4\n\nmesh");
  add("bare LF as the empty line", kPost + "Content-Length: 4\r\n\nmesh");
  add("bare CR in a value", kPost + "X: a\rTransfer-Encoding: chunked\r\n" + body);
  add("CR CR LF", kPost + "X: a\r\r\n" + body);
  add("Host twice", kPost + "Host: b\r\n" + body);
  add("Host twice, equal", kPost + "Host: a\r\n" + body);
  add("no Host", "POST /fracture HTTP/1.1\r\nContent-Type: model/obj\r\n" + body);
  add("a list as Host", "POST /fracture HTTP/1.1\r\nHost: a, b\r\n" + body);
  add("a path as Host", "POST /fracture HTTP/1.1\r\nHost: a/b\r\n" + body);
  add("a user as Host", "POST /fracture HTTP/1.1\r\nHost: a@b\r\n" + body);
  add("a header over the limit", kPost + "X: " + std::string(20'000, 'x') + "\r\n" + body, 431);
  std::string many = kPost;
  for (int i = 0; i < 2000; ++i) many += "X: 12345\r\n";
  add("fields without end", many + body, 431);
}

void add_request_lines(Corpus& corpus) {
  const std::string rest = kFields + "Content-Length: 4\r\n\r\nmesh";
  const auto add = [&](const std::string& line, int status = 400) {
    corpus.push_back({"request line '" + line.substr(0, 60) + "'", line + "\r\n" + rest, status});
  };
  add("POST http://b/fracture HTTP/1.1");
  add("POST //fracture HTTP/1.1", 404);
  add("POST fracture HTTP/1.1");
  add("POST * HTTP/1.1");
  add("POST b:80 HTTP/1.1");
  add("POST /fracture#x HTTP/1.1");
  add("POST /frac ture HTTP/1.1");
  add("POST  /fracture HTTP/1.1");
  add("POST /fracture  HTTP/1.1");
  add("POST\t/fracture\tHTTP/1.1");
  add(" POST /fracture HTTP/1.1");
  add("POST /fracture HTTP/1.1 ");
  add("POST /fracture");
  add("POST /fracture HTTP/1.10");
  add("POST /fracture HTTP/1");
  add("POST /fracture http/1.1");
  add("POST /fracture HTTP/2.0", 505);
  add("POST /fracture HTTP/0.9", 505);
  add("POST /fracture HTTP/1.2", 505);
  add("PO(ST /fracture HTTP/1.1");
  add("POST /%zz HTTP/1.1");
  add("POST /fracture\x01 HTTP/1.1");
  add("POST /fracture\xff HTTP/1.1");
  add("PRI * HTTP/2.0", 505);
  add("CONNECT b:443 HTTP/1.1");
  add("POST /" + std::string(5000, 'x') + " HTTP/1.1", 414);
  add(std::string(20'000, 'x'), 414);
  corpus.push_back({"an empty line first", "\r\n" + kPost + "Content-Length: 4\r\n\r\nmesh", 400});
  corpus.push_back(
      {"a TLS greeting", std::string("\x16\x03\x01\x00\xa5\x01\x00\x00\xa1\x03\x03\n", 12), 400});
}

void add_chunks(Corpus& corpus) {
  const std::string begin = kPost + "Transfer-Encoding: chunked\r\n\r\n";
  const auto add = [&](const char* name, const std::string& chunks, int status = 400, bool valid = false) {
    corpus.push_back({std::string("chunks: ") + name, begin + chunks, status, valid});
  };
  add("good", kChunks, 200, true);
  add("upper and lower case, leading zeros", "0004\r\nmesh\r\n00A\r\n0123456789\r\n0\r\n\r\n", 200, true);
  add("an extension", "4;a=b\r\nmesh\r\n0\r\n\r\n", 200, true);
  add("a trailer", "4\r\nmesh\r\n0\r\nX: y\r\n\r\n", 200, true);
  std::string small;
  for (int i = 0; i < 65'537; ++i) small += "1\r\nm\r\n";
  add("65,537 of one byte", small + "0\r\n\r\n", 200, true);
  add("0x", "0x4\r\nmesh\r\n0\r\n\r\n");
  add("negative", "-4\r\nmesh\r\n0\r\n\r\n");
  add("plus", "+4\r\nmesh\r\n0\r\n\r\n");
  add("a size of 17 digits", "fffffffffffffffff\r\nmesh\r\n0\r\n\r\n");
  add("a size that wraps to 4", "10000000000000004\r\nmesh\r\n0\r\n\r\n");
  add("no size", "\r\nmesh\r\n0\r\n\r\n");
  add("a word as size", "four\r\nmesh\r\n0\r\n\r\n");
  add("space after the size", "4 \r\nmeshX\r\n0\r\n\r\n");
  add("two bytes too many", "4\r\nmeshXX0\r\n\r\n");
  add("bare LF", "4\nmesh\n0\n\n");
  add("bare LF after the data", "4\r\nmesh\n0\r\n\r\n");
  add("bare LF ends the size", "4\nmesh\r\n0\r\n\r\n");
  add("a folded trailer", "4\r\nmesh\r\n0\r\nX: y\r\n z\r\n\r\n", 200, true);  // trailers are thrown away
  add("a giant trailer", "4\r\nmesh\r\n0\r\nX: " + std::string(300'000, 'x') + "\r\n\r\n", 431);
  add("a giant extension", "4;x=" + std::string(300'000, 'x') + "\r\nmesh\r\n0\r\n\r\n", 431);
  add("over the limit of the body", "fffffff\r\n" + std::string(1000, 'x'), 413);
}

}  // namespace

std::size_t count_answers(const std::string& received) {
  const std::string begin = "HTTP/1.1 ";
  std::size_t answers = 0;
  for (std::size_t at = received.find(begin); at != std::string::npos; at = received.find(begin, at + 1))
    answers += at + 9 < received.size() && received[at + 9] >= '1' && received[at + 9] <= '5';
  return answers;
}

std::vector<HostileRequest> hostile_corpus() {
  Corpus corpus;
  add_framing_pairs(corpus);
  add_field_syntax(corpus);
  add_request_lines(corpus);
  add_chunks(corpus);
  return corpus;
}

}  // namespace fracture::test
