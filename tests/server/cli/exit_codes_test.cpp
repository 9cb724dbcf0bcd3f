#include "server/cli/exit_codes.hpp"

#include <gtest/gtest.h>

namespace fracture::cli {
namespace {

TEST(ExitCodes, OfABakeSayTheWorstThatHappened) {
  bake::RunFigures figures;
  figures.made = figures.kept = 3;
  EXPECT_EQ(exit_code(figures, 0), kExitDone);
  figures.refused = 2;
  EXPECT_EQ(exit_code(figures, 0), kExitRefused);
  EXPECT_EQ(exit_code(figures, 1), kExitRefused);
  EXPECT_EQ(exit_code(figures, 2), kExitDone) << "so many were allowed";
  figures.unwritable = 1;
  EXPECT_EQ(exit_code(figures, 2), kExitSystem);
  figures.unsound = 1;
  EXPECT_EQ(exit_code(figures, 2), kExitInternal);
  figures.cancelled = 1;
  EXPECT_EQ(exit_code(figures, 2), kExitInterrupted);
  figures.unavailable = 1;  // what was cancelled, was for want of a server
  EXPECT_EQ(exit_code(figures, 2), kExitSystem);
}

TEST(ExitCodes, OfInspectTellTheMeshFromTheRequest) {
  EXPECT_EQ(inspect_exit_code(ErrorCode::kMeshNotClosed), kInspectRefused);
  EXPECT_EQ(inspect_exit_code(ErrorCode::kMalformedMesh), kInspectRefused);
  EXPECT_EQ(inspect_exit_code(ErrorCode::kBadParameter), kInspectFailed);
  EXPECT_EQ(inspect_exit_code(ErrorCode::kUnknownFormat), kInspectFailed);
}

}  // namespace
}  // namespace fracture::cli
