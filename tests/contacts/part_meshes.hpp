// Solids made of several meshes, one part for each, and their contacts.
#pragma once

#include <array>
#include <vector>

#include "common/contacts/contacts.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {

/// Three unit vectors at right angles.
using Turn = std::array<Vec3d, 3>;
/// Turns by three rational angles (3-4-5, 5-12-13 and 8-15-17 triangles) about z, y and x, so that every
/// coordinate changes.
inline Turn rational_turn() {
  const auto about = [](const Vec3d& p, int axis, double cosine, double sine) {
    Vec3d turned = p;
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    turned[u] = cosine * p[u] - sine * p[v];
    turned[v] = sine * p[u] + cosine * p[v];
    return turned;
  };
  const auto whole = [&](Vec3d p) {
    p = about(p, 2, 3.0 / 5, 4.0 / 5);
    p = about(p, 1, 5.0 / 13, 12.0 / 13);
    return about(p, 0, 8.0 / 17, 15.0 / 17);
  };
  return {whole({1, 0, 0}), whole({0, 1, 0}), whole({0, 0, 1})};
}
inline Vec3d turned(const Vec3d& p, const Turn& turn) {
  return p.x * turn[0] + p.y * turn[1] + p.z * turn[2];
}
inline Mesh turned(Mesh mesh, const Turn& turn) {
  for (Vec3f& p : mesh.positions) {
    const Vec3d q = turned(to_double(p), turn);
    p = {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z)};
  }
  return mesh;
}

/// A solid with the parts of both: only what find_contacts() reads of a solid. Equal parts stay, although
/// make_solid() would keep only one.
inline Solid both(const Solid& a, const Solid& b) {
  Solid solid;
  solid.box = a.box;
  solid.box.add(b.box);
  for (const Solid* from : {&a, &b}) {
    const std::size_t vertices = solid.positions.size(), parts = solid.parts.size();
    solid.positions.insert(solid.positions.end(), from->positions.begin(), from->positions.end());
    for (std::array<VertexId, 3> t : from->triangles) {
      for (VertexId& v : t) v = VertexId{v + vertices};
      solid.triangles.push_back(t);
    }
    for (const std::uint32_t p : from->part) solid.part.push_back(static_cast<std::uint32_t>(p + parts));
    solid.parts.insert(solid.parts.end(), from->parts.begin(), from->parts.end());
  }
  return solid;
}

inline ContactGraph contacts_of(const Solid& solid, double gap) { return find_contacts(solid, gap, {}); }
inline ContactGraph contacts_of(const std::vector<Mesh>& meshes, double gap) {
  return contacts_of(solid_of(joined(meshes)), gap);
}

}  // namespace fracture::test
