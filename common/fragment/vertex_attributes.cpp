#include "common/fragment/vertex_attributes.hpp"

#include <cmath>

namespace fracture {
namespace {

template <class V>
std::array<double, 4> widen(const V& v) {
  if constexpr (requires { v.w; })
    return {v.x, v.y, v.z, v.w};
  else if constexpr (requires { v.z; })
    return {v.x, v.y, v.z, 0};
  else
    return {v.x, v.y, 0, 0};
}

template <class V>
std::array<double, 4> mix(const std::vector<V>& values, const std::array<std::uint32_t, 3>& wedges,
                          const std::array<double, 3>& weights) {
  std::array<double, 4> sum{};
  for (int k = 0; k < 3; ++k) {
    if (weights[k] == 0) continue;
    const std::array<double, 4> v = widen(values[wedges[k]]);
    for (int c = 0; c < 4; ++c) sum[c] += weights[k] * v[c];
  }
  return sum;
}

/// Returns v scaled to unit length, in float, or `fallback` if v vanishes (a mean of opposite directions).
Vec3f unit(const Vec3d& v, const Vec3f& fallback) {
  const double l = length(v);
  if (!(l > 1e-12)) return fallback;
  return {static_cast<float>(v.x / l), static_cast<float>(v.y / l), static_cast<float>(v.z / l)};
}

/// Returns a direction orthogonal to n that depends only on n: the axis least aligned with n, made
/// orthogonal.
Vec3d tangent_of(const Vec3d& n) {
  int axis = 0;
  for (int a = 1; a < 3; ++a)
    if (std::fabs(n[a]) < std::fabs(n[axis])) axis = a;
  Vec3d e;
  e[axis] = 1;
  const Vec3d t = e - dot(e, n) * n;
  return (1 / length(t)) * t;
}

}  // namespace

FlatFrame::FlatFrame(const Vec3d& unit_normal, const std::optional<Vec3d>& grain) : normal(unit_normal) {
  constexpr double kAcross =
      0.3;  // sine of the angle between grain and normal; below it, the face is across the grain
  const Vec3d along = grain ? *grain - dot(*grain, normal) * normal : Vec3d{};
  if (const double size = length(along); size > kAcross) {
    bitangent = (1 / size) * along;
    tangent = cross(bitangent, normal);
  } else {
    tangent = tangent_of(normal);
    bitangent = cross(normal, tangent);
  }
}

AttributeWriter::AttributeWriter(const Attributes& source, Attributes& out, std::size_t count)
    : in_(source), out_(out) {
  if (!in_.normals.empty()) out_.normals.reserve(count);
  if (!in_.tangents.empty()) out_.tangents.reserve(count);
  out_.uvs.resize(in_.uvs.empty() ? 1 : in_.uvs.size());
  for (auto& set : out_.uvs) set.reserve(count);
  out_.colors.resize(in_.colors.size());
  for (auto& set : out_.colors) set.reserve(count);
}

void AttributeWriter::blank() {
  if (in_.uvs.empty()) out_.uvs[0].push_back({0, 0});
}

void AttributeWriter::copy(std::uint32_t w) {
  if (!in_.normals.empty()) out_.normals.push_back(in_.normals[w]);
  if (!in_.tangents.empty()) out_.tangents.push_back(in_.tangents[w]);
  blank();
  for (std::size_t s = 0; s < in_.uvs.size(); ++s) out_.uvs[s].push_back(in_.uvs[s][w]);
  for (std::size_t s = 0; s < in_.colors.size(); ++s) out_.colors[s].push_back(in_.colors[s][w]);
}

void AttributeWriter::blend(const std::array<std::uint32_t, 3>& wedges,
                            const std::array<double, 3>& weights) {
  int heaviest = 0;
  for (int k = 1; k < 3; ++k)
    if (weights[k] > weights[heaviest]) heaviest = k;
  const std::uint32_t main = wedges[heaviest];
  if (!in_.normals.empty()) {
    const auto n = mix(in_.normals, wedges, weights);
    out_.normals.push_back(unit({n[0], n[1], n[2]}, in_.normals[main]));
  }
  if (!in_.tangents.empty()) {
    const auto t = mix(in_.tangents, wedges, weights);
    const Vec4f& m = in_.tangents[main];
    const Vec3f d = unit({t[0], t[1], t[2]}, {m.x, m.y, m.z});
    out_.tangents.push_back({d.x, d.y, d.z, m.w});
  }
  blank();
  for (std::size_t s = 0; s < in_.uvs.size(); ++s) {
    const auto t = mix(in_.uvs[s], wedges, weights);
    out_.uvs[s].push_back({static_cast<float>(t[0]), static_cast<float>(t[1])});
  }
  for (std::size_t s = 0; s < in_.colors.size(); ++s) {
    const auto c = mix(in_.colors[s], wedges, weights);
    out_.colors[s].push_back({static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2]),
                              static_cast<float>(c[3])});
  }
}

void AttributeWriter::interior(const FlatFrame& frame, const Vec3d& p, const Vec3d* rough_normal) {
  const Vec3d& normal = rough_normal ? *rough_normal : frame.normal;
  if (!in_.normals.empty()) out_.normals.push_back(unit(normal, {0, 0, 1}));
  if (!in_.tangents.empty()) {
    const Vec3d& t = frame.tangent;
    const Vec3f d = unit(rough_normal ? t - dot(t, normal) * normal : t, {1, 0, 0});
    out_.tangents.push_back({d.x, d.y, d.z, 1});
  }
  const Vec2f uv{static_cast<float>(dot(p, frame.tangent)), static_cast<float>(dot(p, frame.bitangent))};
  for (auto& set : out_.uvs) set.push_back(uv);
  for (auto& set : out_.colors) set.push_back({1, 1, 1, 1});
}

}  // namespace fracture
