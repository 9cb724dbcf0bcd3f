// Compressed request bodies: what is decoded, what is refused, and what a decompression bomb costs.
#include "server/http/content_coding.hpp"

#include <gtest/gtest.h>
#include <zlib.h>
#include <zstd.h>

#include <random>
#include <stop_token>
#include <thread>
#include <vector>

#include "tests/server/support/gzip.hpp"
#include "tests/server/support/test_server.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/peak_memory.hpp"
#include "tests/support/polls.hpp"

namespace fracture::test {
namespace {

std::string zstd(const std::string& text, int window_log = 0) {
  ZSTD_CCtx* context = ZSTD_createCCtx();
  if (window_log > 0) ZSTD_CCtx_setParameter(context, ZSTD_c_windowLog, window_log);
  ZSTD_CCtx_setParameter(context, ZSTD_c_contentSizeFlag, 0);  // as a stream is written
  std::string out(ZSTD_compressBound(text.size()) + 64, '\0');
  ZSTD_inBuffer in{text.data(), text.size(), 0};
  ZSTD_outBuffer buffer{out.data(), out.size(), 0};
  EXPECT_EQ(ZSTD_compressStream2(context, &buffer, &in, ZSTD_e_end), 0u);
  out.resize(buffer.pos);
  ZSTD_freeCCtx(context);
  return out;
}

std::string fields(const std::string& coding) {
  return "Content-Type: model/obj\r\nContent-Encoding: " + coding + "\r\n";
}

/// Text like a report with varying numbers: it shrinks to less than half.
std::vector<std::uint8_t> compressible(std::size_t size) {
  std::mt19937 random(7);
  std::string text;
  while (text.size() < size) text += "{\"position\": " + std::to_string(random()) + "},\n";
  return {text.begin(), text.begin() + static_cast<std::ptrdiff_t>(size)};
}

/// So garbage is refused as damaged data, not because 4 GiB could not be decoded in time.
TEST(AnnouncedSize, IsNeverMoreThanTheBytesCanDecodeTo) {
  using http::announced_size, http::ContentCoding;
  const std::string zeros(1 << 20, '\0'), packed = gzip(zeros);
  EXPECT_EQ(announced_size(packed, ContentCoding::kGzip), zeros.size())
      << "of the densest body that there is";
  const std::string garbage(300, '\xff');
  EXPECT_EQ(announced_size(garbage, ContentCoding::kGzip), 300u * 1'032);
  std::string frame(ZSTD_compressBound(zeros.size()), '\0');
  frame.resize(ZSTD_compress(frame.data(), frame.size(), zeros.data(), zeros.size(), 19));
  EXPECT_EQ(announced_size(frame, ContentCoding::kZstd), zeros.size());
}

TEST(AnswerCoding, PollsAndMakesTheBytesOfOnePiece) {
  // Two sizes: one fits into a single output block, the other exceeds the window of both codings.
  for (const std::size_t size : {std::size_t{2'000}, std::size_t{5} << 20}) {
    const std::vector<std::uint8_t> body = compressible(size);
    std::vector<std::uint8_t> whole(ZSTD_compressBound(size));
    whole.resize(ZSTD_compress(whole.data(), whole.size(), body.data(), body.size(), 3));
    std::size_t polls = 0;
    Execution execution;
    execution.watch = [&] { ++polls; };
    EXPECT_TRUE(http::encode_body(body, http::ContentCoding::kZstd, execution) == whole) << size;
    EXPECT_GE(polls, size >> 16);

    z_stream stream{};
    ASSERT_EQ(deflateInit2(&stream, Z_BEST_SPEED, Z_DEFLATED, 16 + MAX_WBITS, 8, Z_DEFAULT_STRATEGY), Z_OK);
    whole.resize(deflateBound(&stream, size));
    stream.next_in = const_cast<Bytef*>(body.data());
    stream.avail_in = static_cast<uInt>(size);
    stream.next_out = whole.data();
    stream.avail_out = static_cast<uInt>(whole.size());
    EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
    whole.resize(stream.total_out);
    deflateEnd(&stream);
    polls = 0;
    EXPECT_TRUE(http::encode_body(body, http::ContentCoding::kGzip, execution) == whole) << size;
    EXPECT_GE(polls, size >> 16);
  }
}

TEST(AnswerCoding, IsGivenUpHalfWay) {
  const std::vector<std::uint8_t> body = compressible(5 << 20);
  for (const http::ContentCoding coding : {http::ContentCoding::kGzip, http::ContentCoding::kZstd}) {
    Polls polls(10);
    EXPECT_THROW(http::encode_body(body, coding, polls.execution), Interrupted);
    EXPECT_EQ(polls.count, 10);
  }
}

/// The memory of a request is released shortly after its answer has been passed on.
testing::AssertionResult all_given_back(TestServer& server) {
  return eventually(kPatience, "all bodies to be given back",
                    [&] { return server.api.bodies().whole().used() == 0; });
}

TEST(ContentCoding, ADecodedBodyIsChargedWithItselfAndNoLongerWithWhatCame) {
  MemoryBudget budget(100u << 20);
  MemoryBudget::Reservation reservation(budget);
  std::string mesh(1u << 20, '\0');
  for (std::size_t k = 0; k < mesh.size(); ++k) mesh[k] = static_cast<char>(k * k * 2654435761u >> 13);
  std::string body = gzip(mesh);
  ASSERT_TRUE(reservation.grow_to(body.size()));
  EXPECT_FALSE(http::decode_body(body, http::ContentCoding::kGzip, 100u << 20, reservation, {}).problem);
  EXPECT_EQ(body, mesh);
  EXPECT_EQ(budget.used(), body.capacity());
}

TEST(ContentCoding, ACompressedBodyIsTheSameRequest) {
  TestServer server;
  const std::string mesh(100'000, 'm');
  const Reply plain = server.post("/fracture", mesh, "Content-Type: model/obj\r\n");
  ASSERT_EQ(plain.status, 200);
  const std::string half = mesh.substr(0, 50'000);
  const std::pair<const char*, std::string> same[] = {{"identity", mesh},
                                                      {"gzip", gzip(mesh)},
                                                      {"x-gzip", gzip(mesh)},
                                                      {"GZIP", gzip(mesh)},
                                                      {"zstd", zstd(mesh)},
                                                      {"gzip", gzip(half) + gzip(half)},
                                                      {"zstd", zstd(half) + zstd(half)}};
  for (const auto& [coding, body] : same) {
    const Reply reply = server.post("/fracture", body, fields(coding));
    EXPECT_EQ(reply.status, 200) << coding << reply.body;
    EXPECT_EQ(reply.header("etag"), plain.header("etag")) << coding;
  }
  EXPECT_EQ(server.control->imports, 1) << "one mesh, one import";
  EXPECT_TRUE(all_given_back(server));
}

TEST(ContentCoding, OtherCodingsAre415WithWhatWouldDo) {
  TestServer server;
  for (const char* coding : {"br", "deflate", "gzip, gzip", "gzip, zstd", "gzip;q=1", "compress", "*"}) {
    const Reply reply = server.post("/fracture", "mesh", fields(coding));
    EXPECT_EQ(reply.status, 415) << coding;
    EXPECT_EQ(reply.problem(), "unsupported-coding") << coding;
    EXPECT_EQ(reply.header("accept-encoding"), "gzip, zstd") << coding;
  }
  EXPECT_EQ(server.post("/fracture", gzip("mesh"), fields("gzip") + fields("gzip")).status, 415)
      << "two fields are a list of two";
}

TEST(ContentCoding, DamagedBodiesAre400) {
  TestServer server;
  const std::string text(10'000, 'x');
  const std::string g = gzip(text), z = zstd(text);
  std::string flipped_g = g, flipped_z = z;
  flipped_g[g.size() - 6] ^= 1;  // in the checksum
  flipped_z[2] ^= 1;             // in the magic number
  const std::pair<const char*, std::string> damaged[] = {{"gzip", "mesh"},
                                                         {"zstd", "mesh"},
                                                         {"gzip", z},
                                                         {"zstd", g},
                                                         {"gzip", flipped_g},
                                                         {"zstd", flipped_z},
                                                         {"gzip", g.substr(0, g.size() - 1)},
                                                         {"zstd", z.substr(0, z.size() - 1)},
                                                         {"gzip", g + "tail"},
                                                         {"zstd", z + "tail"},
                                                         {"gzip", g.substr(0, 5)}};
  for (const auto& [coding, body] : damaged)
    EXPECT_EQ(server.post("/fracture", body, fields(coding)).problem(), "malformed-coding")
        << coding << " of " << body.size() << " bytes";
  EXPECT_EQ(server.post("/fracture", gzip(""), fields("gzip")).problem(), "empty-body");
  EXPECT_EQ(server.control->imports, 0);
}

TEST(ContentCoding, ABombIs413AndCostsNoMemory) {
  TestServerOptions options;
  options.limits.max_decoded_body = 256u << 20;
  TestServer server(options);
  const std::string zeros(64u << 20, '\0');
  std::string g = gzip(zeros), z = zstd(zeros);
  std::string bomb_g, bomb_z;
  for (int i = 0; i < 8; ++i) {  // 512 MiB each
    bomb_g += g;
    bomb_z += z;
  }
  const PeakMemory peak;
  for (const auto& [coding, body] : {std::pair("gzip", bomb_g), std::pair("zstd", bomb_z)}) {
    const Reply reply = server.post("/fracture", body, fields(coding));
    EXPECT_EQ(reply.problem(), "body-too-large") << coding;
    EXPECT_NE(reply.body.find("268.4 MB, which is the limit (--max-decoded)"), std::string::npos)
        << reply.body;
  }
  EXPECT_TRUE(peak.grew_by_less_than(32 << 20));
  EXPECT_EQ(server.control->imports, 0);
  EXPECT_TRUE(all_given_back(server));
}

TEST(ContentCoding, TheLimitHoldsToTheByte) {
  TestServerOptions options;
  options.limits.max_decoded_body = 100'000;
  TestServer server(options);
  EXPECT_EQ(server.post("/fracture", gzip(std::string(100'000, 'x')), fields("gzip")).status, 200);
  EXPECT_EQ(server.post("/fracture", gzip(std::string(100'001, 'x')), fields("gzip")).status, 413);
  EXPECT_EQ(server.post("/fracture", zstd(std::string(100'001, 'x')), fields("zstd")).status, 413);
}

TEST(ContentCoding, AWindowOver8MiBIsRefused) {
  // Such a window is not worth its memory, and RFC 9659 forbids it for a content coding.
  std::string text(20u << 20, '\0');
  for (std::size_t i = 0; i < text.size(); i += 1000) text[i] = static_cast<char>(i * 2654435761u >> 24);
  MemoryBudget budget(100u << 20);
  MemoryBudget::Reservation reservation(budget);
  std::string small = zstd(text, 23), large = zstd(text, 24);
  EXPECT_FALSE(http::decode_body(small, http::ContentCoding::kZstd, 100u << 20, reservation, {}).problem);
  EXPECT_EQ(small, text);
  const auto refused =
      http::decode_body(large, http::ContentCoding::kZstd, 100u << 20, reservation, {}).problem;
  ASSERT_TRUE(refused);
  EXPECT_NE(refused->body("").find("window of more than 8 MiB"), std::string::npos) << refused->body("");
}

TEST(ContentCoding, DecodedBytesCountAgainstTheMemoryOfAllBodies) {
  TestServerOptions options;
  options.limits.max_bodies = 90'000;
  TestServer server(options);
  const Reply reply = server.post("/fracture", gzip(std::string(100'000, 'x')), fields("gzip"));
  EXPECT_EQ(reply.status, 503);
  EXPECT_NE(reply.header("retry-after"), "");
  EXPECT_TRUE(all_given_back(server));
}

TEST(ContentCoding, ACancelledRequestStopsDecoding) {
  std::stop_source stop;
  stop.request_stop();
  Execution execution;
  execution.stop = stop.get_token();
  MemoryBudget budget(100u << 20);
  MemoryBudget::Reservation reservation(budget);
  std::string body = gzip(std::string(1u << 20, 'x'));
  EXPECT_THROW(http::decode_body(body, http::ContentCoding::kGzip, 100u << 20, reservation, execution),
               Interrupted);
  body.clear();
  for (int k = 0; k < 1000; ++k) body += gzip("");
  EXPECT_THROW(http::decode_body(body, http::ContentCoding::kGzip, 100u << 20, reservation, execution),
               Interrupted)
      << "members that hold nothing";
}

int polls_of_decoding(std::string body, http::ContentCoding coding, std::uint64_t decoded) {
  int polls = 0;
  Execution execution;
  execution.watch = [&polls] { ++polls; };
  MemoryBudget budget(100u << 20);
  MemoryBudget::Reservation reservation(budget);
  EXPECT_FALSE(http::decode_body(body, coding, 100u << 20, reservation, execution).problem);
  EXPECT_EQ(body.size(), decoded);
  return polls;
}

/// A gzip member with empty stored blocks, which are five bytes each (RFC 1951, section 3.2.4).
std::string gzip_of_empty_blocks(int count) {
  const std::string packed = gzip("");  // ten bytes of header, an empty last block, eight bytes of trailer
  std::string blocks;
  for (int k = 0; k < count; ++k) blocks.append("\0\0\0\xff\xff", 5);
  return packed.substr(0, 10) + blocks + packed.substr(10);
}

/// A zstd frame with empty raw blocks, which are three bytes each (RFC 8878, section 3.1.1.2).
std::string zstd_of_empty_blocks(int count) {
  std::string frame("\x28\xb5\x2f\xfd\0\x50", 6);  // a window of 1 MiB; no size, no checksum
  for (int k = 0; k < count; ++k) frame.append("\0\0\0", 3);
  return frame.append("\1\0\0", 3);  // the last one
}

// The body is decoded twice. A poll comes after each 16 KiB that were read or 256 KiB that were written, whichever is first.
TEST(ContentCoding, DecodingPollsForWhatItReadsAndWrites) {
  using http::ContentCoding;
  const std::string zeros(8u << 20, '\0');
  EXPECT_GE(polls_of_decoding(gzip(zeros), ContentCoding::kGzip, zeros.size()), 2 * 32);
  EXPECT_GE(polls_of_decoding(zstd(zeros), ContentCoding::kZstd, zeros.size()), 2 * 32);
  const int blocks = 100'000;
  EXPECT_GE(polls_of_decoding(gzip_of_empty_blocks(blocks), ContentCoding::kGzip, 0), 2 * (5 * blocks >> 14));
  EXPECT_GE(polls_of_decoding(zstd_of_empty_blocks(blocks), ContentCoding::kZstd, 0), 2 * (3 * blocks >> 14));
}

}  // namespace
}  // namespace fracture::test
