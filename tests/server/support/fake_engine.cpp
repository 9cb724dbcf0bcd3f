#include "tests/server/support/fake_engine.hpp"

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "server/service/figures.hpp"

namespace fracture::test {
namespace {

GltfFile located(std::vector<std::uint8_t> file, OutputFormat format) {
  const TextRange figures = figures_in(file, format).value_or(TextRange());
  return {std::move(file), figures};
}

}  // namespace

FakeEngine::FakeEngine(std::shared_ptr<FakeControl> control) : control_(std::move(control)) {}

Expected<Mesh> FakeEngine::import(std::span<const std::byte> bytes, MeshFormat,
                                  std::span<const ImportFile> files, std::string_view, const ImportLimits&,
                                  const Execution& execution) const {
  ++control_->imports;
  execution.poll();
  if (control_->files) control_->files(files);
  if (control_->during_import) control_->during_import(execution);
  if (control_->import) return control_->import({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  return Mesh{};
}

Expected<Solid> FakeEngine::prepare(std::shared_ptr<const Mesh> mesh, const SolidOptions&,
                                    const HollowOptions&, const Execution&) const {
  ++control_->prepares;
  Solid solid;
  solid.report.volume = 1;
  solid.source = std::move(mesh);
  return solid;
}

Expected<CutBase> FakeEngine::base(const Solid&, const FractureParameters& parameters, const Selection&,
                                   const Execution&) const {
  ++control_->diagrams;
  Diagram diagram;
  diagram.sites.resize(parameters.sites);
  return diagram;
}

Expected<Cut> FakeEngine::cut(const Solid&, const CutBase& base, const FractureParameters&, const Selection&,
                              const Execution& execution) const {
  ++control_->cuts;
  try {
    if (control_->during_cut) control_->during_cut(execution);
  } catch (const Interrupted& interrupted) {
    if (interrupted.code == ErrorCode::kCancelled) ++control_->cancelled;
    throw;
  }
  if (control_->cut_error)
    if (std::optional<Error> error = control_->cut_error()) return tl::unexpected<Error>(std::move(*error));
  Cut cut;
  cut.fractured.set.certificate.fragments = static_cast<std::uint32_t>(std::get<Diagram>(base).sites.size());
  return cut;
}

GltfFile FakeEngine::encode(const FracturedSolid& fractured, const GltfOptions& options, OutputFormat format,
                            const Execution&) const {
  std::string text =
      nlohmann::json{
          {"asset", {{"version", "2.0"}, {"extras", {{"parameters", options.parameters}}}}},
          {"nodes",
           {{{"extras",
              {{"fracture",
                {{"parameters", options.parameters},
                 {"mesh", options.mesh_digest},
                 {"fragments", fractured.set.certificate.fragments},
                 {"certificate", {{"open_edges", 0}, {"fragments", fractured.set.certificate.fragments}}},
                 {"bonds", nlohmann::json::object()}}}}}}}}}
          .dump();
  text.resize((text.size() + 3) / 4 * 4 + control_->glb_padding, ' ');
  if (format == OutputFormat::kGltf) return located({text.begin(), text.end()}, format);
  std::vector<std::uint8_t> glb(20 + text.size());
  const std::uint32_t header[5] = {0x46546C67u, 2u, static_cast<std::uint32_t>(glb.size()),
                                   static_cast<std::uint32_t>(text.size()), 0x4E4F534Au};
  std::memcpy(glb.data(), header, sizeof header);
  std::memcpy(glb.data() + 20, text.data(), text.size());
  return located(std::move(glb), format);
}

}  // namespace fracture::test
