// Helpers for the tests of our own readers (STL, PLY, OFF).
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "tests/import/make_files.hpp"

namespace fracture::test {

inline Mesh must_import(std::string_view bytes, MeshFormat format, std::span<const ImportFile> files = {},
                        const ImportLimits& limits = {}) {
  Expected<Mesh> mesh = import_text(bytes, format, limits, files);
  EXPECT_TRUE(mesh) << (mesh ? "" : mesh.error().detail);
  return mesh ? std::move(*mesh) : Mesh{};
}

inline Error must_refuse(std::string_view bytes, MeshFormat format, const ImportLimits& limits = {}) {
  const Expected<Mesh> mesh = import_text(bytes, format, limits);
  EXPECT_FALSE(mesh) << "it was read";
  return mesh ? Error{ErrorCode::kInternal, "it was read", {}, {}} : mesh.error();
}

/// The positions of a triangle's corners, in order.
inline std::array<Vec3f, 3> corners_of(const Mesh& mesh, std::size_t triangle) {
  const auto& t = mesh.triangles.at(triangle);
  return {mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]};
}

/// Replaces each line feed.
inline std::string with_line_ends(std::string_view text, std::string_view end) {
  std::string result;
  for (const char c : text) result += c == '\n' ? std::string(end) : std::string(1, c);
  return result;
}

/// Appends numbers as big-endian bytes.
template <class T>
void put_big(std::string& out, std::initializer_list<T> values) {
  for (const T value : values) {
    std::string raw;
    put<T>(raw, {value});
    out.append(raw.rbegin(), raw.rend());
  }
}

/// The corners of a cube of side 1 with four corners for each side, and its twelve triangles, facing outwards. Volume 1.
inline constexpr std::array<std::array<float, 3>, 8> kCubeCorners{
    {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}};
inline constexpr std::array<std::array<int, 3>, 12> kCubeTriangles{{{0, 3, 2},
                                                                    {0, 2, 1},
                                                                    {4, 5, 6},
                                                                    {4, 6, 7},
                                                                    {0, 1, 5},
                                                                    {0, 5, 4},
                                                                    {1, 2, 6},
                                                                    {1, 6, 5},
                                                                    {2, 3, 7},
                                                                    {2, 7, 6},
                                                                    {3, 0, 4},
                                                                    {3, 4, 7}}};

}  // namespace fracture::test
