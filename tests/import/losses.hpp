// The entries of Mesh::dropped, for tests of glTF files.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "tests/import/make_files.hpp"

namespace fracture::test {

/// The mesh of a file that must be readable.
inline Mesh import_with_losses(const Tetrahedron& tet) {
  Expected<Mesh> mesh = import_text(tet.glb(), MeshFormat::kGlb);
  EXPECT_TRUE(mesh) << (mesh ? "" : mesh.error().detail);
  return mesh ? std::move(*mesh) : Mesh{};
}

/// "what name" of each entry. Every entry has a reason.
inline std::vector<std::string> dropped_by(const Tetrahedron& tet) {
  std::vector<std::string> texts;
  for (const Dropped& entry : import_with_losses(tet).dropped) {
    EXPECT_FALSE(entry.reason.empty()) << entry.what << entry.name;
    texts.push_back(entry.what + " " + entry.name);
  }
  return texts;
}

}  // namespace fracture::test
