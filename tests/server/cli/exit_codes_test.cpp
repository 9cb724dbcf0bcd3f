#include "server/cli/exit_codes.hpp"

#include <gtest/gtest.h>

#include <initializer_list>
#include <utility>

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
  figures.unavailable = 1;  // the rest was cancelled because no server was available
  EXPECT_EQ(exit_code(figures, 2), kExitSystem);
}

TEST(ExitCodes, OfACommandThatEndsWithAnErrorAreThoseOfABakeOfOneMesh) {
  for (const auto& [code, expected] :
       std::initializer_list<std::pair<ErrorCode, int>>{{ErrorCode::kMeshNotClosed, kExitRefused},
                                                        {ErrorCode::kMalformedMesh, kExitRefused},
                                                        {ErrorCode::kBadParameter, kExitRefused},
                                                        {ErrorCode::kUnknownFormat, kExitRefused},
                                                        {ErrorCode::kFileAccess, kExitSystem},
                                                        {ErrorCode::kUnavailable, kExitSystem},
                                                        {ErrorCode::kInternal, kExitInternal},
                                                        {ErrorCode::kOutOfMemory, kExitInternal},
                                                        {ErrorCode::kUnsound, kExitInternal},
                                                        {ErrorCode::kCancelled, kExitInterrupted}})
    EXPECT_EQ(exit_code(code), expected) << slug(code);
}

}  // namespace
}  // namespace fracture::cli
