#include "common/base/atomic_file.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <stdexcept>
#include <string_view>

namespace fracture {
namespace {

namespace fs = std::filesystem;

std::span<const std::byte> text_bytes(std::string_view text) { return std::as_bytes(std::span(text)); }

struct AtomicFileTest : testing::Test {
  std::string folder;

  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "atomic_file_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    folder = name;
  }
  void TearDown() override { fs::remove_all(folder); }

  std::string path(const std::string& name) const { return folder + "/" + name; }
  std::string text_of(const std::string& name) const {
    std::ifstream file(path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  std::set<std::string> names() const {
    std::set<std::string> found;
    for (const auto& entry : fs::directory_iterator(folder)) found.insert(entry.path().filename().string());
    return found;
  }
};

using Names = std::set<std::string>;

TEST_F(AtomicFileTest, IsThereWhenItIsCommitted) {
  ASSERT_TRUE(write_atomically(path("a"), text_bytes("old")));
  AtomicFile file;
  ASSERT_TRUE(file.open(path("a")));
  ASSERT_TRUE(file.append(text_bytes("ne")));
  ASSERT_TRUE(file.append_paced(text_bytes("w")));
  EXPECT_EQ(text_of("a"), "old");
  EXPECT_EQ(names(), (Names{"a", ".a.part"}));
  ASSERT_TRUE(file.commit());
  EXPECT_EQ(text_of("a"), "new");
  EXPECT_EQ(names(), Names{"a"});
}

TEST_F(AtomicFileTest, LeavesNothingIfItIsNotCommitted) {
  {
    AtomicFile file;
    ASSERT_TRUE(file.open(path("a")));
    ASSERT_TRUE(file.append(text_bytes("half")));
  }
  EXPECT_EQ(names(), Names{});
}

TEST_F(AtomicFileTest, LeavesNothingIfTheTargetCannotBeReplaced) {
  fs::create_directories(path("a/b"));
  errno = 0;
  EXPECT_FALSE(write_atomically(path("a"), text_bytes("text")));
  EXPECT_TRUE(errno == EISDIR || errno == ENOTEMPTY || errno == EEXIST) << errno;
  EXPECT_EQ(names(), Names{"a"});
}

TEST_F(AtomicFileTest, SaysThatAFolderIsMissing) {
  EXPECT_FALSE(write_atomically(path("absent/a"), text_bytes("text")));
  EXPECT_EQ(errno, ENOENT);
}

TEST_F(AtomicFileTest, TakesThePathAndTheModeOfItsTemporaryFile) {
  fs::create_directories(path("tmp"));
  AtomicFile file;
  ASSERT_TRUE(file.open(path("a"), {.temporary = path("tmp/7"), .mode = 0600, .flushed = false}));
  EXPECT_TRUE(fs::exists(path("tmp/7")));
  ASSERT_TRUE(file.append(text_bytes("text")));
  ASSERT_TRUE(file.commit());
  EXPECT_FALSE(fs::exists(path("tmp/7")));
  struct stat status {};
  ASSERT_EQ(::stat(path("a").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
  EXPECT_EQ(text_of("a"), "text");
}

// Somebody else may have made the link, and it may point to a file that must stay.
TEST_F(AtomicFileTest, FollowsNoLinkAtThePlaceOfTheTemporaryFile) {
  ASSERT_TRUE(write_atomically(path("precious"), text_bytes("mine")));
  fs::create_symlink(path("precious"), path(".a.part"));
  EXPECT_FALSE(write_atomically(path("a"), text_bytes("text")));
  EXPECT_EQ(errno, ELOOP);
  EXPECT_EQ(text_of("precious"), "mine");
}

}  // namespace
}  // namespace fracture
