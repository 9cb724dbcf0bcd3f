#include <cmath>

#include "common/outputs/outputs.hpp"

namespace fracture::outputs {
namespace {

/// The unit normal; zero if the triangle has no area, as STL requires.
Vec3f normal_of(const Vec3f corners[3]) {
  const Vec3d a = to_double(corners[0]);
  const Vec3d n = cross(to_double(corners[1]) - a, to_double(corners[2]) - a);
  const double length = std::sqrt(dot(n, n));
  if (!(length > 0) || !std::isfinite(length)) return {};
  return {static_cast<float>(n.x / length), static_cast<float>(n.y / length),
          static_cast<float>(n.z / length)};
}

}  // namespace

bool write_stl(const Answer& answer, const Sink& sink) {
  Blocks out(sink);
  // Readers treat a file that begins with "solid" as text.
  std::string head = answer.generator.substr(0, 60) + "; metres, y up";
  constexpr std::size_t kHead = 80;
  if (const std::string offset = answer.offset_text();
      !offset.empty() && head.size() + 2 + offset.size() <= kHead)
    head += "; " + offset;
  head.resize(kHead, ' ');
  out.text(head).raw(static_cast<std::uint32_t>(answer.triangles()));
  for (const Object& object : answer.objects)
    for (const Primitive& primitive : object.primitives) {
      if (!out.good()) return false;
      for (std::size_t k = 0; k < primitive.indices.size(); k += 3) {
        Vec3f corners[3];
        for (std::size_t c = 0; c < 3; ++c) corners[c] = object.position(primitive.indices[k + c]);
        const Vec3f n = normal_of(corners);
        out.raw(n.x).raw(n.y).raw(n.z);
        for (const Vec3f& p : corners) out.raw(p.x).raw(p.y).raw(p.z);
        out.raw(std::uint16_t{0});
      }
    }
  return out.finish();
}

}  // namespace fracture::outputs
