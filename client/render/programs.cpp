#include "client/render/programs.hpp"

#include <utility>

#include "client/render/gpu_model.hpp"

namespace fracture::render {
namespace {

std::string text_of(Tier tier, ShaderParts parts) {
  std::string text = "#version 330 core\n";
  if (tier == Tier::kHigh) text += "#define HIGH\n";
  for (const char* part : parts) text += shader_text(part);
  return text;
}

constexpr std::pair<const char*, int> kSamplers[] = {
    {"object_table", kObjectTable},
    {"base_color_map", kBaseColor},
    {"metallic_roughness_map", kMetallicRoughness},
    {"normal_map", kNormalMap},
    {"occlusion_map", kOcclusion},
    {"emissive_map", kEmissive},
    {"sun_map", kSunShadow},
    {"sky_maps", kSkyShadows},
    {"behind", kBehind},
    {"scene_depth", kSceneDepth},
    {"sun_depths", kSunDepths},
    {"clear_map", kClearShadow},
    {"sky_map", kSkyMap},
    {"screen_occlusion", kScreenOcclusion},
    {"glass_front", kGlassFront},
    {"glass_back", kGlassBack},
};

}  // namespace

Expected<Program> build_program(const std::string& name, Tier tier, ShaderParts vertex,
                                ShaderParts fragment) {
  Expected<Program> program = Program::build(name, text_of(tier, vertex), text_of(tier, fragment));
  if (!program) return program;
  program->use();
  program->bind_block("Frame", kFrameBinding);
  for (const auto& [uniform, unit] : kSamplers) program->set(uniform, unit);
  return program;
}

}  // namespace fracture::render
