// The formats that Assimp reads: order, wedges and texture coordinates as in the file. No other file is read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/import/make_files.hpp"

namespace fracture::test {
namespace {

using ::testing::HasSubstr;

TEST(BlendImport, DamagedZstandardIsRefused) {
  const Expected<Mesh> mesh = import_text("\x28\xb5\x2f\xfd" + std::string(100, 'x'), MeshFormat::kBlend);
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().code, ErrorCode::kMalformedMesh);
  EXPECT_THAT(mesh.error().detail, HasSubstr("damaged"));
}

TEST(BlendImport, DamagedGzipIsRefused) {
  const Expected<Mesh> mesh = import_text("\x1f\x8b" + std::string(100, 'x'), MeshFormat::kBlend);
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().code, ErrorCode::kMalformedMesh);
}

}  // namespace
}  // namespace fracture::test
