#include <algorithm>
#include <cmath>

#include "common/outputs/outputs.hpp"

namespace fracture::outputs {
namespace {

/// Writes numbers that were floats: 0.45 instead of 0.44999998807907104.
void line(Blocks& out, const char* keyword, std::initializer_list<double> numbers) {
  out.text(keyword);
  for (const double number : numbers) out.text(" ").number(static_cast<float>(number));
  out.text("\n");
}

void write_map(Blocks& out, const char* keyword, const std::optional<Map>& map,
               const std::vector<std::string>& textures) {
  if (!map) return;
  out.text(keyword);
  const auto option = [&](const char* name, double u, double v, const char* w) {
    out.text(name).number(static_cast<float>(u)).text(" ").number(static_cast<float>(v)).text(w);
  };
  if (map->scale[0] != 1 || map->scale[1] != 1) option(" -s ", map->scale[0], map->scale[1], " 1");
  // With v up: 1 - (offset + scale * (1 - v)) = scale * v + (1 - offset - scale).
  if (const double u = map->offset[0], v = 1 - map->offset[1] - map->scale[1]; u != 0 || v != 0)
    option(" -o ", u, v, " 0");
  out.text(" ").text(textures[map->image]).text("\n");
}

/// Blinn-Phong exponent of a roughness: alpha = roughness^2 = sqrt(2 / (n + 2)) (Walter et al. 2007), the
/// inverse of the conversion in import. At most the maximum of MTL.
double exponent_of(double roughness) {
  constexpr double kSmoothest = 1000;
  const double alpha = roughness * roughness;
  return alpha * alpha * (kSmoothest + 2) > 2 ? 2 / (alpha * alpha) - 2 : kSmoothest;
}

}  // namespace

bool write_mtl(const Answer& answer, const std::vector<std::string>& textures, const Sink& sink) {
  Blocks out(sink);
  out.text("# ").text(answer.generator).text("\n");
  for (const Material& material : answer.materials) {
    out.text("newmtl ").text(material.name).text("\n");
    line(out, "Kd", {material.color.x, material.color.y, material.color.z});
    line(out, "d", {material.opacity});
    if (material.roughness) line(out, "Ns", {exponent_of(*material.roughness)});
    if (material.roughness) line(out, "Pr", {*material.roughness});
    if (material.metallic) line(out, "Pm", {*material.metallic});
    if (const Vec3d& e = material.emission; !(e == Vec3d{})) line(out, "Ke", {e.x, e.y, e.z});
    out.text("illum 2\n");
    write_map(out, "map_Kd", material.color_map, textures);
    write_map(out, "norm", material.normal_map, textures);
    write_map(out, "map_Ke", material.emission_map, textures);
  }
  const bool bare = std::any_of(answer.objects.begin(), answer.objects.end(), [](const Object& object) {
    return std::any_of(object.primitives.begin(), object.primitives.end(),
                       [](const Primitive& p) { return p.material == kNoMaterial; });
  });
  if (bare) out.text("newmtl ").text(kBareMaterial).text("\nKd 1 1 1\nd 1\nillum 2\n");
  return out.finish();
}

std::vector<std::size_t> images_of_mtl(const Answer& answer) {
  std::vector<std::size_t> images;
  for (const Material& material : answer.materials)
    for (const auto* map : {&material.color_map, &material.normal_map, &material.emission_map})
      if (*map) images.push_back((*map)->image);
  std::sort(images.begin(), images.end());
  images.erase(std::unique(images.begin(), images.end()), images.end());
  return images;
}

}  // namespace fracture::outputs
