#include "common/import/obj_import.hpp"

#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/base/words.hpp"
#include "common/import/mesh_builder.hpp"
#include "common/import/obj_materials.hpp"
#include "common/import/obj_text.hpp"
#include "common/import/polygon_triangles.hpp"
#include "common/import/refused.hpp"
#include "common/import/text_encoding.hpp"
#include "common/import/transform.hpp"

namespace fracture {
namespace {

/// Numbers the different corners (position, texture coordinate, normal) of a surface in the order of their first use. Open
/// addressing, so that time is linear whatever the indices are.
class CornerNumbers {
 public:
  struct Corner {
    std::uint32_t position, uv, normal;
    friend bool operator==(const Corner&, const Corner&) = default;
  };

  CornerNumbers() : slots_(64, kNoIndex) {}

  /// `last`: the number of the last corner at this position, perhaps of another surface. Usually the same corner is meant, and
  /// neighbouring faces have it in the cache.
  std::uint32_t of(const Corner& corner, std::uint32_t& last) {
    if (last >= corners_.size() || !(corners_[last] == corner)) last = find(corner);
    return last;
  }
  const std::vector<Corner>& corners() const { return corners_; }

 private:
  std::uint32_t find(const Corner& corner) {
    for (std::size_t slot = slot_of(corner);; slot = (slot + 1) & (slots_.size() - 1)) {
      if (slots_[slot] == kNoIndex) {
        const auto number = static_cast<std::uint32_t>(corners_.size());
        slots_[slot] = number;
        corners_.push_back(corner);
        if (2 * corners_.size() > slots_.size()) grow();
        return number;
      }
      if (corners_[slots_[slot]] == corner) return slots_[slot];
    }
  }
  std::size_t slot_of(const Corner& c) const {
    std::uint64_t hash = c.position * 0x9e3779b97f4a7c15ull;
    hash = (std::rotl(hash, 29) ^ c.uv) * 0x9e3779b97f4a7c15ull;
    hash = (std::rotl(hash, 29) ^ c.normal) * 0x9e3779b97f4a7c15ull;
    return (hash ^ hash >> 32) & (slots_.size() - 1);
  }
  void grow() {
    slots_.assign(2 * slots_.size(), kNoIndex);
    for (std::uint32_t k = 0; k < corners_.size(); ++k) {
      std::size_t slot = slot_of(corners_[k]);
      while (slots_[slot] != kNoIndex) slot = (slot + 1) & (slots_.size() - 1);
      slots_[slot] = k;
    }
  }

  std::vector<std::uint32_t> slots_;
  std::vector<Corner> corners_;
};

/// Replaces indices of values that do not exist. The appearance suffers, but not the shape, so this is a warning.
void drop_wrong_indices(std::vector<std::uint32_t>& indices, std::size_t values, const ObjHighest& highest,
                        const char* kind, Remarks& remarks) {
  if (highest.line == 0 || highest.index < values) return;
  std::uint64_t dropped = 0;
  for (std::uint32_t& index : indices)
    if (index != kNoIndex && index >= values) {
      index = kNoIndex;
      ++dropped;
    }
  if (dropped == 0) return;  // the face had too few corners
  remarks.warn(counted(dropped, "corner uses a ", "corners use a ") + kind +
               " that the OBJ does not contain: line " + std::to_string(highest.line) + " uses number " +
               std::to_string(highest.index + 1) + ", but the file has " +
               (values == 0 ? "none" : "only " + grouped(values)) + ". " +
               (dropped == 1 ? "This corner has no " : "These corners have no ") + kind +
               " in the answer and may look wrong. Export the file again.");
}

class ObjMesh {
 public:
  explicit ObjMesh(ObjText text)
      : text_(std::move(text)),
        offset_(text_.positions.offset()),
        positions_(text_.positions.rounded(offset_)),
        last_(positions_.size(), kNoIndex) {}

  void add_to(MeshBuilder& builder) {
    for (const std::uint32_t r : runs_by_object()) {
      const ObjRun& run = text_.runs[r];
      if (node_ != run.object) {
        node_ = run.object;
        builder.begin_node(name_of(text_.objects[node_]));
      }
      if (auto added = builder.add(surface_of(r)); !added) throw Refused{added.error()};
    }
  }
  const Vec3d& offset() const { return offset_; }

 private:
  /// "defaultobject" is how exporters name faces without an object.
  static std::string name_of(const std::string& name) {
    return name.empty() || name == "defaultobject" || name[0] == '<' ? "mesh" : name_as_utf8(name);
  }

  /// The runs, object by object, each in the order of the file.
  std::vector<std::uint32_t> runs_by_object() const {
    std::vector<std::uint32_t> begin(text_.objects.size() + 1, 0), order(text_.runs.size());
    for (const ObjRun& run : text_.runs) ++begin[run.object + 1];
    for (std::size_t k = 1; k < begin.size(); ++k) begin[k] += begin[k - 1];
    for (std::uint32_t r = 0; r < order.size(); ++r) order[begin[text_.runs[r].object]++] = r;
    return order;
  }

  Surface surface_of(std::uint32_t r) {
    const std::size_t end = r + 1 < text_.runs.size() ? text_.runs[r + 1].face : text_.corners_of_face.size();
    CornerNumbers numbers;
    Surface surface;
    std::size_t corner = text_.runs[r].corner;
    for (std::size_t face = text_.runs[r].face; face < end; ++face) {
      const std::uint32_t count = text_.corners_of_face[face];
      wedges_.clear();
      for (std::uint32_t k = 0; k < count; ++k, ++corner)
        wedges_.push_back(numbers.of({text_.position[corner], text_.uv.empty() ? kNoIndex : text_.uv[corner],
                                      text_.normal.empty() ? kNoIndex : text_.normal[corner]},
                                     last_[text_.position[corner]]));
      if (count == 3) {
        surface.triangles.push_back({wedges_[0], wedges_[1], wedges_[2]});
        continue;
      }
      corners_.clear();
      for (std::size_t k = corner - count; k < corner; ++k)
        corners_.push_back(text_.positions[text_.position[k]]);
      divided_.clear();
      append_polygon(corners_, 0, divided_);
      for (const auto& t : divided_)
        surface.triangles.push_back({wedges_[t[0]], wedges_[t[1]], wedges_[t[2]]});
    }
    surface.materials.assign(surface.triangles.size(), text_.runs[r].material);
    add_values(numbers.corners(), surface);
    merge_identical_wedges(surface);  // a file may repeat a value under another index
    return surface;
  }

  void add_values(const std::vector<CornerNumbers::Corner>& corners, Surface& surface) const {
    bool uvs = false, normals = false;
    for (const auto& c : corners) {
      uvs |= c.uv != kNoIndex;
      normals |= c.normal != kNoIndex;
    }
    surface.positions.reserve(corners.size());
    for (const auto& c : corners) surface.positions.push_back(positions_[c.position]);
    if (normals) {
      surface.attributes.normals.reserve(corners.size());
      for (const auto& c : corners)
        surface.attributes.normals.push_back(
            c.normal == kNoIndex ? Vec3f{} : unit_float(to_double(text_.normals[c.normal])));
    }
    if (uvs) {
      auto& set = surface.attributes.uvs.emplace_back();
      set.reserve(corners.size());
      for (const auto& c : corners) {  // v points up in OBJ, and down in glTF
        const Vec2f uv = c.uv == kNoIndex ? Vec2f{} : text_.uvs[c.uv];
        set.push_back({uv.x, 1.0f - uv.y});
      }
    }
    if (!text_.colors.empty()) {
      auto& set = surface.attributes.colors.emplace_back();
      set.reserve(corners.size());
      for (const auto& c : corners) set.push_back(text_.colors[c.position]);
    }
  }

  ObjText text_;
  Vec3d offset_;
  std::vector<Vec3f> positions_;
  std::vector<std::uint32_t> last_;  ///< per position (CornerNumbers)
  std::uint32_t node_ = kNoIndex;
  std::vector<std::uint32_t> wedges_;  ///< of a face
  std::vector<Vec3d> corners_;         ///< of a polygon
  std::vector<std::array<std::uint32_t, 3>> divided_;
};

void list_left_out(const ObjText& text, std::vector<Dropped>& dropped) {
  for (const ObjLeftOut& kind : text.left_out)
    dropped.push_back({kind.what,
                       kind.count == 1
                           ? "on line " + std::to_string(kind.line)
                           : grouped(kind.count) + " of them, the first on line " + std::to_string(kind.line),
                       kind.reason});
}

}  // namespace

Expected<Mesh> import_obj(std::span<const std::byte> bytes, const ImportLimits& limits,
                          std::span<const ImportFile> files) {
  try {
    ObjMaterials materials(files);
    ObjText text =
        read_obj_text({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, limits, materials);
    MeshBuilder builder(limits);
    drop_wrong_indices(text.uv, text.uvs.size(), text.highest_uv, "texture coordinate", builder.remarks());
    drop_wrong_indices(text.normal, text.normals.size(), text.highest_normal, "normal", builder.remarks());
    std::vector<bool> used(materials.size(), false);
    for (const ObjRun& run : text.runs)
      if (run.material != kNoIndex) used[run.material] = true;
    std::vector<Dropped> dropped;
    list_left_out(text, dropped);
    builder.set_library(materials.finish(used, builder.remarks(), dropped));
    ObjMesh obj(std::move(text));
    obj.add_to(builder);
    Expected<Mesh> mesh = builder.finish();
    if (!mesh) return mesh;
    mesh->frame.offset = obj.offset();
    mesh->dropped = std::move(dropped);
    return mesh;
  } catch (const Refused& refused) {
    return tl::unexpected<Error>(refused.error);
  }
}

}  // namespace fracture
