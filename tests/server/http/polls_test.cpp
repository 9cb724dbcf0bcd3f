// How often the passes over a form poll: a pass that does not would keep the thread from other clients.
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "server/http/multipart.hpp"
#include "tests/support/polls.hpp"

namespace fracture::http {
namespace {

constexpr std::size_t kMiB = std::size_t{1} << 20;

struct Counted {
  OrProblem<std::vector<FormPart>> parts;
  int polls = 0;
};

Counted parsed(const std::string& form, const std::string& boundary = "b") {
  test::Polls polls;
  auto parts = parse_multipart(form, boundary, polls.execution);
  return {std::move(parts), polls.count};
}

std::string form_of(const std::string& mesh) {
  return "--b\r\nContent-Disposition: form-data; name=mesh; filename=a.obj\r\n\r\n" + mesh + "\r\n--b--";
}

TEST(MultipartPolls, AreOneForEachQuarterOfAMebibyteWhateverTheMeshIs) {
  for (const char flood : {'a', '\r', '\n', '-', 'b'}) {
    const std::string mesh(8 * kMiB, flood);
    const std::string form = form_of(mesh);
    const Counted counted = parsed(form);
    ASSERT_TRUE(counted.parts) << counted.parts.error().detail;
    EXPECT_EQ(counted.parts->front().body, mesh);
    EXPECT_GE(counted.polls, 32) << flood;
    EXPECT_LE(counted.polls, 34) << flood;
  }
}

TEST(MultipartPolls, AFirstBoundaryIsOnlyLookedForWhereItMayBe) {
  for (const char flood : {'a', '\r'}) {
    const Counted without = parsed(std::string(8 * kMiB, flood));
    ASSERT_FALSE(without.parts);
    EXPECT_NE(without.parts.error().detail.find("4,096"), std::string::npos) << without.parts.error().detail;
    EXPECT_EQ(without.polls, 1) << flood;
  }
}

TEST(MultipartPolls, ThePreambleHasALimit) {
  const std::string form = "\r\n" + form_of("v 0 0 0\n");
  EXPECT_TRUE(parsed(std::string(kMaxAround, '\r') + form).parts);
  EXPECT_FALSE(parsed(std::string(kMaxAround + 1, '\r') + form).parts);
  EXPECT_TRUE(parsed(form).parts);
}

TEST(MultipartPolls, AFormIsGivenUpHalfWay) {
  const std::string form = form_of(std::string(8 * kMiB, '\r'));
  test::Polls polls(10);
  EXPECT_THROW((void)parse_multipart(form, "b", polls.execution), Interrupted);
  EXPECT_EQ(polls.count, 10);
}

}  // namespace
}  // namespace fracture::http
