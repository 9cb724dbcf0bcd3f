#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <unordered_map>

#include "common/base/srgb.hpp"
#include "common/outputs/outputs.hpp"

namespace fracture::outputs {
namespace {

template <std::size_t N>
using Bits = std::array<std::uint32_t, N>;

struct HashOfBits {
  template <std::size_t N>
  std::size_t operator()(const Bits<N>& bits) const {
    std::uint64_t hash = 0;
    for (const std::uint32_t b : bits) hash = (std::rotl(hash, 23) ^ b) * 0x9e3779b97f4a7c15;
    return hash ^ (hash >> 32);
  }
};

/// Numbers values in the order of their first use.
template <std::size_t N>
class Numbering {
 public:
  /// The number of a value, from 0, and whether it is new.
  std::pair<std::size_t, bool> of(const Bits<N>& bits) {
    const auto [at, fresh] = numbers_.try_emplace(bits, numbers_.size());
    return {at->second, fresh};
  }
  std::size_t size() const { return numbers_.size(); }

 private:
  std::unordered_map<Bits<N>, std::size_t, HashOfBits> numbers_;
};

/// For each vertex, the vertex that represents all vertices at the same point of the surface.
std::vector<std::uint32_t> merged_vertices(const Object& object) {
  const std::size_t count = object.positions.size();
  std::vector<std::uint32_t> merged(count);
  for (std::uint32_t v = 0; v < count; ++v) merged[v] = v;
  if (!object.manifold) {
    Numbering<3> places;
    std::vector<std::uint32_t> first;
    for (std::uint32_t v = 0; v < count; ++v) {
      const auto [place, fresh] = places.of(std::bit_cast<Bits<3>>(object.position(v)));
      if (fresh) first.push_back(v);
      merged[v] = first[place];
    }
    return merged;
  }
  std::size_t primitive = 0, before = 0;  // number of corners in previous primitives; corners ascend
  for (std::size_t k = 0; k < object.merge_corners.size(); ++k) {
    const std::size_t corner = object.merge_corners[k];
    if (corner < before) primitive = before = 0;
    while (corner - before >= object.primitives[primitive].indices.size())
      before += object.primitives[primitive++].indices.size();
    merged[object.primitives[primitive].indices[corner - before]] = object.merge_vertices[k];
  }
  return merged;
}

class ObjWriter {
 public:
  ObjWriter(const Answer& answer, VertexColors colors, const Sink& sink)
      : answer_(answer), colors_(colors), out_(sink) {}

  bool operator()(const std::string& materials) {
    out_.text("# ").text(answer_.generator).text("\n# metres, y up\n");
    if (const std::string offset = answer_.offset_text(); !offset.empty())
      out_.text("# ").text(offset).text("\n");
    out_.text("mtllib ").text(materials).text("\n");
    for (const Object& object : answer_.objects) {
      if (!out_.good()) break;
      write(object);
    }
    return out_.finish();
  }

 private:
  void write(const Object& object) {
    out_.text("o ").text(object.name).text("\n");
    if (object.id) out_.text("# id ").number(*object.id).text("\n");
    write_positions(object);
    write_normals(object);
    sets_.clear();
    for (const Primitive& primitive : object.primitives) {
      const std::vector<std::size_t>* uvs = write_uvs(object, primitive);
      out_.text("usemtl ").text(primitive.material == kNoMaterial
                                    ? std::string_view(kBareMaterial)
                                    : std::string_view(answer_.materials[primitive.material].name));
      out_.text("\n");
      write_faces(object, primitive.indices, uvs);
    }
  }

  void write_positions(const Object& object) {
    const std::vector<std::uint32_t> merged = merged_vertices(object);
    Numbering<4> numbers;
    v_.resize(merged.size());
    for (std::size_t vertex = 0; vertex < merged.size(); ++vertex) {
      Bits<4> key{merged[vertex]};
      if (!object.colors.empty())
        for (std::size_t k = 0; k < 3; ++k)
          key[k + 1] = std::bit_cast<std::uint32_t>(object.colors.at(vertex, k));
      const auto [number, fresh] = numbers.of(key);
      v_[vertex] = positions_ + number;
      if (!fresh) continue;
      const Vec3f p = object.position(merged[vertex]);
      out_.text("v ").number(p.x).text(" ").number(p.y).text(" ").number(p.z);
      if (!object.colors.empty())
        for (std::size_t k = 0; k < 3; ++k) write_color(object.colors.at(vertex, k));
      out_.text("\n");
    }
    positions_ += numbers.size();
  }

  void write_color(float component) {
    out_.text(" ");
    if (colors_ == VertexColors::kKeep) {
      out_.number(component);
      return;
    }
    constexpr double kSteps =
        1e4;  // finer than any screen, coarser than the difference between two pow() libraries
    out_.number(std::round(to_srgb(component) * kSteps) / kSteps);
  }

  void write_normals(const Object& object) {
    Numbering<3> numbers;
    vn_.resize(object.normals.size());
    for (std::size_t vertex = 0; vertex < vn_.size(); ++vertex) {
      const Vec3f n = object.normal(vertex);
      const auto [number, fresh] = numbers.of(std::bit_cast<Bits<3>>(n));
      vn_[vertex] = normals_ + number;
      if (fresh) out_.text("vn ").number(n.x).text(" ").number(n.y).text(" ").number(n.z).text("\n");
    }
    normals_ += numbers.size();
  }

  /// Writes the texture coordinates that the primitive's material uses. Returns null if there are none.
  const std::vector<std::size_t>* write_uvs(const Object& object, const Primitive& primitive) {
    std::size_t set = 0;
    if (primitive.material != kNoMaterial)
      if (const auto& map = answer_.materials[primitive.material].color_map) set = map->uv_set;
    if (set >= object.uvs.size()) set = 0;
    if (object.uvs.empty()) return nullptr;
    const auto [at, fresh_set] = sets_.try_emplace(set);
    if (!fresh_set) return &at->second;
    const Floats& uvs = object.uvs[set];
    Numbering<2> numbers;
    at->second.resize(uvs.size());
    for (std::size_t vertex = 0; vertex < uvs.size(); ++vertex) {
      const float u = uvs.at(vertex, 0), v = 1 - uvs.at(vertex, 1);  // glTF's v points down
      const auto [number, fresh] =
          numbers.of({std::bit_cast<std::uint32_t>(u), std::bit_cast<std::uint32_t>(v)});
      at->second[vertex] = uvs_ + number;
      if (fresh) out_.text("vt ").number(u).text(" ").number(v).text("\n");
    }
    uvs_ += numbers.size();
    return &at->second;
  }

  void write_faces(const Object& object, const Indices& indices, const std::vector<std::size_t>* uvs) {
    for (std::size_t k = 0; k < indices.size(); ++k) {
      const std::uint32_t vertex = indices[k];
      out_.text(k % 3 == 0 ? "f " : " ").number(v_[vertex] + 1);  // OBJ counts from one
      if (uvs != nullptr) out_.text("/").number((*uvs)[vertex] + 1);
      if (!object.normals.empty()) out_.text(uvs != nullptr ? "/" : "//").number(vn_[vertex] + 1);
      if (k % 3 == 2) out_.text("\n");
    }
  }

  const Answer& answer_;
  const VertexColors colors_;
  Blocks out_;
  std::size_t positions_ = 0, normals_ = 0, uvs_ = 0;     ///< written so far
  std::vector<std::size_t> v_, vn_;                       ///< for the object: numbers of each vertex
  std::map<std::size_t, std::vector<std::size_t>> sets_;  ///< for the object: the same for each UV set
};

}  // namespace

bool write_obj(const Answer& answer, const std::string& materials, VertexColors colors, const Sink& sink) {
  return ObjWriter(answer, colors, sink)(materials);
}

double to_srgb(double linear) { return srgb_of_linear(std::clamp(linear, 0.0, 1.0)); }

}  // namespace fracture::outputs
