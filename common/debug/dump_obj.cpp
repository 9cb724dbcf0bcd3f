#include "common/debug/dump_obj.hpp"
#include "common/solid/cut_materials.hpp"

#include <charconv>
#include <ostream>
#include <string>

namespace fracture::debug {
namespace {

void write_vertex(std::ostream& out, const Vec3f& p) {
  char text[64];
  out << 'v';
  for (const float c : {p.x, p.y, p.z}) {
    const auto result = std::to_chars(text, text + sizeof(text), c);
    out << ' ' << std::string_view(text, static_cast<std::size_t>(result.ptr - text));
  }
  out << '\n';
}

void write_vertex(std::ostream& out, const Vec3d& p) {
  write_vertex(out, Vec3f{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
}

/// OBJ counts from one.
void write_face(std::ostream& out, std::size_t first, std::size_t a, std::size_t b, std::size_t c) {
  out << "f " << first + a + 1 << ' ' << first + b + 1 << ' ' << first + c + 1 << '\n';
}

std::string slot_name(std::uint32_t material) {
  if (material == kInteriorMaterial) return "interior";
  if (material == kMortarMaterial) return "mortar";
  return material == kNoIndex ? "none" : "slot_" + std::to_string(material);
}

/// Writes "usemtl" when the material changes.
class MaterialRuns {
 public:
  explicit MaterialRuns(std::ostream& out) : out_(out) {}
  void use(std::uint32_t material) {
    if (!begun_ || material != current_) out_ << "usemtl " << slot_name(material) << '\n';
    begun_ = true;
    current_ = material;
  }

 private:
  std::ostream& out_;
  bool begun_ = false;
  std::uint32_t current_ = 0;
};

}  // namespace

void dump_obj(std::ostream& out, const Mesh& mesh) {
  for (const Vec3f& p : mesh.positions) write_vertex(out, p);
  MaterialRuns materials(out);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (t == 0 || mesh.node[t] != mesh.node[t - 1]) out << "o node_" << mesh.node[t] << '\n';
    materials.use(mesh.material[t]);
    write_face(out, 0, mesh.triangles[t][0], mesh.triangles[t][1], mesh.triangles[t][2]);
  }
}

void dump_obj(std::ostream& out, const Solid& solid) {
  for (const Vec3f& p : solid.positions) write_vertex(out, p);
  MaterialRuns materials(out);
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    if (t == 0 || solid.part[t] != solid.part[t - 1]) out << "o part_" << solid.part[t] << '\n';
    if (t == 0 || solid.shell[t] != solid.shell[t - 1]) out << "g shell_" << solid.shell[t] << '\n';
    materials.use(solid.material[t]);
    write_face(out, 0, solid.triangles[t][0], solid.triangles[t][1], solid.triangles[t][2]);
  }
}

void dump_obj_of_sites(std::ostream& out, const Tetrahedralization& t, double radius) {
  out << "o sites\n";
  for (const SiteId s : ids<SiteId>(t.site_count())) {
    for (int corner = 0; corner < 6; ++corner) {  // +x, -x, +y, -y, +z, -z
      Vec3d p = t.points[s];
      p[corner / 2] += corner % 2 ? -radius : radius;
      write_vertex(out, p);
    }
    for (std::size_t octant = 0; octant < 8; ++octant) {
      const std::size_t x = octant & 1, y = octant >> 1 & 1, z = octant >> 2 & 1;
      // Each mirroring reverses the orientation.
      const bool mirrored = (x + y + z) % 2 == 1;
      const std::size_t first = 6 * std::size_t{s};
      write_face(out, first, x, mirrored ? 4 + z : 2 + y, mirrored ? 2 + y : 4 + z);
    }
  }
}

void dump_obj(std::ostream& out, const Tetrahedralization& t, double shrink) {
  out << "o tetrahedra\n";
  std::size_t first = 0;
  for (const Tetrahedron& tet : t.tets) {
    Vec3d middle;
    bool inner = true;
    for (const SiteId s : tet.v) {
      inner = inner && !t.is_corner(s);
      middle = middle + 0.25 * t.points[s];
    }
    if (!inner) continue;
    for (const SiteId s : tet.v) write_vertex(out, t.points[s] + shrink * (middle - t.points[s]));
    for (const auto& facet : kFacet) write_face(out, first, facet[0], facet[1], facet[2]);
    first += 4;
  }
}

void dump_obj(std::ostream& out, const FragmentSet& set, double explode) {
  Box box;
  for (const Fragment& f : set.fragments) box.add(f.mass.center_of_mass);
  std::size_t first = 0;
  for (const Fragment& f : set.fragments) {
    out << "o fragment_" << f.id << '\n';
    const Vec3d shift = explode * (f.mass.center_of_mass - box.center());
    for (const Vec3f& p : f.positions) {
      // World positions are float32(local) + float32(pivot), which is exact if explode is 0 (I2).
      const Vec3d world = to_double(p) + f.pivot + shift;
      write_vertex(out, world);
    }
    for (const FragmentPrimitive& primitive : f.primitives) {
      out << "usemtl " << slot_name(primitive.material) << '\n';
      for (std::uint32_t k = primitive.first_index; k < primitive.first_index + primitive.index_count; k += 3)
        write_face(out, first, f.indices[k], f.indices[k + 1], f.indices[k + 2]);
    }
    first += f.positions.size();
  }
}

}  // namespace fracture::debug
