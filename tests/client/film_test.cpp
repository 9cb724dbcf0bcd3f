// Films: folders of PNG files, and an encoder program that succeeds, fails or never ends.
#include "client/film/film.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>

#include "tests/server/support/temporary_folder.hpp"

namespace fracture::film {
namespace {

using std::chrono::milliseconds;
constexpr int kWidth = 65, kHeight = 34;  // mp4 needs even sides, so one side is odd

FilmSettings settings(const std::string& program = "ffmpeg", milliseconds patience = milliseconds(30000)) {
  return {.width = kWidth, .height = kHeight, .rate = 60, .program = program, .patience = patience};
}

render::Picture picture(int number) {
  return {kWidth, kHeight, {static_cast<std::uint8_t>(4 * number), 120, 40, 255}};
}

class Films : public testing::Test {
 protected:
  std::string script(const std::string& text) {
    const std::string path = folder_.write("program", "#!/bin/sh\n" + text + "\n");
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
    return path;
  }
  /// Makes a film of this many pictures. Returns the first error.
  Expected<void> make(const std::string& file, const FilmSettings& how, int pictures = 30) {
    Expected<Film> film = Film::create(folder_ / file, how);
    if (!film) return tl::unexpected(film.error());
    for (int k = 0; k < pictures; ++k)
      if (auto added = film->add(picture(k)); !added) return added;
    return film->finish();
  }
  static bool installed(const char* program) {
    return std::system((std::string("command -v ") + program + " >/dev/null 2>&1").c_str()) == 0;
  }
  /// Number of pictures in a film, counted by another program.
  int pictures_in(const std::string& file) {
    const std::string command =
        "ffprobe -v error -count_frames -select_streams v -show_entries stream=nb_read_frames -of csv=p=0 '" +
        (folder_ / file) + "'";
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(::popen(command.c_str(), "r"), ::pclose);
    int count = -1;
    return pipe && std::fscanf(pipe.get(), "%d", &count) == 1 ? count : -1;
  }
  std::string text_of(const std::string& file) {
    std::ifstream in(folder_ / file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder_.path), {}));
  }
  test::TemporaryFolder folder_;
};

// Shell commands that read all pictures and set `target` to the film's file, which is the last argument
// without "file:".
constexpr const char* kTarget = "cat >/dev/null; for last; do :; done; target=${last#file:}; ";

TEST_F(Films, AFolderHasAPictureForEachFrame) {
  const Expected<void> made = make("frames", settings("there-is-no-such-program"), 3);
  ASSERT_TRUE(made) << made.error().detail;
  for (const char* name : {"frame-00000.png", "frame-00001.png", "frame-00002.png"}) {
    std::ifstream in((folder_ / "frames") + "/" + name, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    const auto read =
        render::decode_picture(std::span(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()));
    ASSERT_TRUE(read) << name;
    EXPECT_EQ(read->at(5, 5)[0], 4 * (name[10] - '0'));
  }
}

TEST_F(Films, AFilmHasThePicturesThatWereAdded) {
  if (!installed("ffmpeg") || !installed("ffprobe")) GTEST_SKIP() << "ffmpeg is not installed";
  for (const auto& [file, pictures] :
       {std::pair("a.mp4", 30), std::pair("b.gif", 13)}) {  // Half a second; a GIF has 25 pictures a second.
    const Expected<void> made = make(file, settings());
    ASSERT_TRUE(made) << made.error().detail;
    EXPECT_NEAR(pictures_in(file), pictures, 1) << file;
  }
}

TEST_F(Films, AMissingProgramIsSaidAtOnce) {
  const Expected<void> made = make("a.mp4", settings("there-is-no-such-program"));
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::kNoProgram);
  EXPECT_NE(made.error().detail.find("there-is-no-such-program"), std::string::npos);
}

TEST_F(Films, AProgramThatFailsIsAnErrorWithItsWords) {
  const Expected<void> made = make("a.mp4", settings(script("echo the disk is full >&2; exit 3")), 2000);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::kNoProgram);
  EXPECT_NE(made.error().detail.find("the disk is full"), std::string::npos) << made.error().detail;
}

TEST_F(Films, AProgramThatTakesNothingOrNeverEndsIsWaitedForNoLongerThanPatience) {
  const auto start = std::chrono::steady_clock::now();
  const Expected<void> stuck = make("a.mp4", settings(script("exec sleep 600"), milliseconds(200)), 2000);
  ASSERT_FALSE(stuck);
  EXPECT_NE(stuck.error().detail.find("accepts no more"), std::string::npos) << stuck.error().detail;
  const Expected<void> endless =
      make("a.mp4", settings(script("cat >/dev/null; exec sleep 600"), milliseconds(200)), 2);
  ASSERT_FALSE(endless);
  EXPECT_NE(endless.error().detail.find("does not end"), std::string::npos) << endless.error().detail;
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(60));
}

TEST_F(Films, AFilmThatIsNotWholeLeavesWhatWasThereAndNothingElse) {
  for (const char* what :
       {"", "echo x >\"$target\"; echo No space left on device >&2", "rm \"$target\"", "exit 3"}) {
    folder_.write("a.gif", "old");
    const Expected<void> made = make("a.gif", settings(script(kTarget + std::string(what))), 3);
    ASSERT_FALSE(made) << what;
    EXPECT_EQ(made.error().code, ErrorCode::kNoProgram) << what;
    EXPECT_EQ(text_of("a.gif"), "old") << what;
    EXPECT_EQ(files(), 2u) << "the film and the program: " << what;
  }
  const Expected<void> full = make(
      "a.gif", settings(script(kTarget + std::string("echo x >\"$target\"; echo the disk is full >&2"))), 3);
  ASSERT_FALSE(full) << "although the program ended with 0";
  EXPECT_NE(full.error().detail.find("the disk is full"), std::string::npos) << full.error().detail;
}

TEST_F(Films, AFilmTakesItsNameWhenItIsWholeWhateverTheNameHolds) {
  for (const char* name : {"x%d.webp", "%05d.gif", "a b'c.mp4"}) {
    folder_.write(name, "old");
    const Expected<void> made =
        make(name, settings(script(kTarget + std::string("echo \"$target\" >\"$target\""))), 3);
    ASSERT_TRUE(made) << made.error().detail;
    const std::string written = text_of(name);
    EXPECT_EQ(written.find('%'), std::string::npos) << "ffmpeg would put numbers there: " << written;
    EXPECT_TRUE(written.ends_with(std::filesystem::path(name).extension().string() + "\n")) << written;
    EXPECT_FALSE(std::filesystem::exists(written.substr(0, written.size() - 1)));
  }
  if (!installed("ffmpeg")) GTEST_SKIP() << "ffmpeg is not installed";
  const Expected<void> made = make("real%d.gif", settings());
  ASSERT_TRUE(made) << made.error().detail;
  EXPECT_TRUE(text_of("real%d.gif").starts_with("GIF"));
}

TEST_F(Films, AFilmThatIsGivenUpLeavesNothing) {
  {
    Expected<Film> film = Film::create(folder_ / "a.gif", settings(script("exec sleep 600")));
    ASSERT_TRUE(film);
    const Film moved = std::move(*film);
    EXPECT_EQ(files(), 2u);
  }
  EXPECT_EQ(files(), 1u) << "the program";
}

TEST_F(Films, AFilmIsNotWrittenOverAFolderOrAnEarlierFilmOfPictures) {
  std::filesystem::create_directory(folder_ / "a.gif");
  const Expected<void> over = make("a.gif", settings(), 1);
  ASSERT_FALSE(over);
  EXPECT_EQ(over.error().code, ErrorCode::kFileAccess);
  ASSERT_TRUE(make("frames", settings(), 3));
  const Expected<void> shorter = make("frames", settings(), 1);
  ASSERT_FALSE(shorter) << "the second and third picture would be of the longer film";
  EXPECT_EQ(shorter.error().code, ErrorCode::kFileAccess);
  EXPECT_NE(shorter.error().detail.find("frames contains an earlier film"), std::string::npos);
  const Expected<void> nowhere = make("absent/a.gif", settings(), 1);
  ASSERT_FALSE(nowhere);
  EXPECT_EQ(nowhere.error().code, ErrorCode::kFileAccess);
}

TEST_F(Films, APictureOfAnotherSizeIsRefused) {
  Expected<Film> film = Film::create(folder_ / "frames", settings());
  ASSERT_TRUE(film);
  const Expected<void> added = film->add(render::Picture(8, 8));
  ASSERT_FALSE(added);
  EXPECT_EQ(added.error().code, ErrorCode::kBadParameter);
}

}  // namespace
}  // namespace fracture::film
