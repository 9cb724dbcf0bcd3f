// The tests' own readers of OBJ, PLY and STL. They read only the parts of the formats that outputs.hpp
// promises, and use none of its code.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "common/base/vec.hpp"
#include "common/gltf/gltf_writer.hpp"
#include "common/outputs/outputs.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::outputs::test {

using Point = std::array<float, 3>;
using Triangle = std::array<Point, 3>;

inline double volume_of(const std::vector<Triangle>& triangles) {
  double six = 0;
  for (const Triangle& t : triangles) {
    const auto at = [&](int k) { return Vec3d{t[k][0], t[k][1], t[k][2]}; };
    six += dot(at(0), cross(at(1), at(2)));
  }
  return six / 6;
}

/// Counts directed edges without a matching opposite edge. A corner may be represented by any type.
template <class Corner>
std::size_t open_edges(const std::vector<std::array<Corner, 3>>& triangles) {
  std::map<std::pair<Corner, Corner>, int> balance;
  for (const auto& t : triangles)
    for (int k = 0; k < 3; ++k) {
      const Corner &a = t[k], &b = t[(k + 1) % 3];
      if (a == b) continue;
      a < b ? ++balance[{a, b}] : --balance[{b, a}];
    }
  std::size_t open = 0;
  for (const auto& [edge, sum] : balance) open += sum != 0;
  return open;
}

struct ObjObject {
  std::string name{};
  std::vector<Triangle> triangles{};
  std::vector<std::array<long, 3>> v{};  ///< of the same triangles
  std::vector<std::string> materials{};  ///< of the same triangles
  std::vector<std::array<std::pair<float, float>, 3>> uvs{};
  std::vector<std::array<Point, 3>> normals{};
};

struct ObjFile {
  std::string library;
  std::vector<ObjObject> objects;
  std::vector<Point> positions, colors, normals;

  explicit ObjFile(const std::string& text) {
    std::vector<std::pair<float, float>> uvs;
    std::istringstream lines(text);
    std::string material;
    for (std::string line; std::getline(lines, line);) {
      std::istringstream words(line);
      std::string word;
      words >> word;
      if (word == "mtllib") library = line.substr(7);
      if (word == "o") objects.push_back({.name = line.substr(2)});
      if (word == "usemtl") material = line.substr(7);
      const auto numbers = [&] {
        std::vector<float> values;
        for (std::string text_of; words >> text_of;) values.push_back(std::stof(text_of));
        return values;
      };
      if (word == "v") {
        const auto p = numbers();
        positions.push_back({p.at(0), p.at(1), p.at(2)});
        if (p.size() == 6) colors.push_back({p[3], p[4], p[5]});
      }
      if (word == "vn") {
        const auto n = numbers();
        normals.push_back({n.at(0), n.at(1), n.at(2)});
      }
      if (word == "vt") {
        const auto t = numbers();
        uvs.push_back({t.at(0), t.at(1)});
      }
      if (word != "f") continue;
      ObjObject& object = objects.back();
      Triangle triangle{};
      std::array<long, 3> v{};
      std::array<std::pair<float, float>, 3> vt{};
      std::array<Point, 3> vn{};
      for (std::size_t k = 0; k < 3; ++k) {
        std::string corner;
        words >> corner;
        const std::size_t first = corner.find('/'), second = corner.find('/', first + 1);
        v[k] = std::stol(corner);
        triangle[k] = positions.at(static_cast<std::size_t>(v[k] - 1));
        if (first != std::string::npos && second > first + 1)
          vt[k] = uvs.at(static_cast<std::size_t>(std::stol(corner.substr(first + 1)) - 1));
        if (second != std::string::npos)
          vn[k] = normals.at(static_cast<std::size_t>(std::stol(corner.substr(second + 1)) - 1));
      }
      object.triangles.push_back(triangle);
      object.v.push_back(v);
      object.uvs.push_back(vt);
      object.normals.push_back(vn);
      object.materials.push_back(material);
    }
  }
};

/// A PLY of scalars and triangles: properties by name, as doubles, element by element.
struct PlyFile {
  struct Element {
    std::string name;
    std::size_t count = 0;
    /// Type and name; "list" for the triangle
    std::vector<std::pair<std::string, std::string>> properties{};
  };
  std::vector<std::string> comments;
  std::vector<std::map<std::string, double>> vertices, faces;
  std::vector<std::array<std::size_t, 3>> corners;
  std::vector<Point> positions;
  std::size_t left = 0;  ///< bytes after the last face

  explicit PlyFile(const std::string& bytes) {
    const std::size_t end = bytes.find("end_header\n");
    std::istringstream lines(bytes.substr(0, end));
    std::vector<Element> elements;
    for (std::string line; std::getline(lines, line);) {
      std::istringstream words(line);
      std::string word, type, name;
      words >> word;
      if (word == "comment") comments.push_back(line.substr(8));
      if (word == "element") {
        words >> name;
        elements.push_back({.name = name});
        words >> elements.back().count;
      }
      if (word == "property") {
        words >> type >> name;
        if (type == "list") {
          EXPECT_EQ(line, "property list uchar int vertex_indices");
        }
        elements.back().properties.emplace_back(type, name);
      }
    }
    const char* at = bytes.data() + end + 11;
    const auto take = [&](auto value) {
      EXPECT_LE(at + sizeof value, bytes.data() + bytes.size());
      std::memcpy(&value, at, sizeof value);
      at += sizeof value;
      return value;
    };
    for (const Element& element : elements)
      for (std::size_t k = 0; k < element.count; ++k) {
        std::map<std::string, double> values;
        for (const auto& [type, name] : element.properties) {
          if (type == "float") values[name] = take(0.0f);
          if (type == "uchar") values[name] = take(std::uint8_t{0});
          if (type == "int") values[name] = take(std::int32_t{0});
          if (type != "list") continue;
          EXPECT_EQ(take(std::uint8_t{0}), 3);
          std::array<std::size_t, 3> corner{};
          for (std::size_t& c : corner) c = static_cast<std::size_t>(take(std::int32_t{0}));
          corners.push_back(corner);
        }
        (element.name == "vertex" ? vertices : faces).push_back(values);
        if (element.name == "vertex")
          positions.push_back({static_cast<float>(values["x"]), static_cast<float>(values["y"]),
                               static_cast<float>(values["z"])});
      }
    left = static_cast<std::size_t>(bytes.data() + bytes.size() - at);
  }

  std::map<int, std::vector<Triangle>> fragments() const {
    std::map<int, std::vector<Triangle>> result;
    for (std::size_t f = 0; f < corners.size(); ++f) {
      Triangle t{};
      for (std::size_t k = 0; k < 3; ++k) t[k] = positions.at(corners[f][k]);
      result[static_cast<int>(faces[f].at("fragment"))].push_back(t);
    }
    return result;
  }
};

inline std::vector<Triangle> stl_triangles(const std::string& bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, &bytes.at(80), 4);
  EXPECT_EQ(bytes.size(), 84 + std::size_t{50} * count);
  std::vector<Triangle> triangles(count);
  for (std::size_t k = 0; k < count; ++k) std::memcpy(&triangles[k], &bytes.at(84 + 50 * k + 12), 36);
  return triangles;
}

/// Options with one member that is not the default.
template <class Member, class Value>
GltfOptions with(Member GltfOptions::*member, Value value) {
  GltfOptions options;
  options.*member = value;
  return options;
}

/// An answer with its bytes.
struct KeptAnswer : Answer {
  std::vector<std::uint8_t> bytes;

  explicit KeptAnswer(std::vector<std::uint8_t> glb) : bytes(std::move(glb)) {
    Expected<Answer> answer = read_answer(bytes);
    if (!answer) throw std::runtime_error(answer.error().detail);
    Answer::operator=(std::move(*answer));
  }
  KeptAnswer(const KeptAnswer&) = delete;
};
inline KeptAnswer read(std::vector<std::uint8_t> glb) { return KeptAnswer(std::move(glb)); }

inline Sink into(std::string& text) {
  return [&text](std::string_view block) {
    text += block;
    return true;
  };
}
inline std::string obj_of(const Answer& answer, VertexColors colors = VertexColors::kToSrgb) {
  std::string text;
  EXPECT_TRUE(write_obj(answer, "x.mtl", colors, into(text)));
  return text;
}
inline std::string ply_of(const Answer& answer, VertexColors colors = VertexColors::kToSrgb) {
  std::string text;
  EXPECT_TRUE(write_ply(answer, colors, into(text)));
  return text;
}
inline std::string stl_of(const Answer& answer) {
  std::string text;
  EXPECT_TRUE(write_stl(answer, into(text)));
  return text;
}

/// A ball far from the origin, in pieces with rough cuts.
inline const fracture::test::Fractured& broken_ball() {
  static const fracture::test::Fractured made = [] {
    const Mesh ball = fracture::test::translated(fracture::test::sphere_with(600), {100.1, -7.3, 0.01});
    FractureParameters parameters;
    parameters.sites = 24;
    parameters.roughness = {0.05, 5, 2};
    return fracture::test::fracture_mesh(ball, parameters);
  }();
  return made;
}

}  // namespace fracture::outputs::test
