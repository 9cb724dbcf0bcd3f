// An engine that computes nothing: it counts its calls, and does what a test tells it to do.
#pragma once

#include <atomic>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/service/engine.hpp"
#include "server/service/figures.hpp"

namespace fracture::test {

/// Counters and hooks, shared between the test and the engine that the service owns.
struct FakeControl {
  std::atomic<int> imports{0}, prepares{0}, diagrams{0}, cuts{0}, cancelled{0};
  /// Runs inside cut(); may block, throw, or poll the execution.
  std::function<void(const Execution&)> during_cut;
  std::function<std::optional<Error>()> cut_error;  ///< of cut(), after during_cut
  /// Runs inside import(); an error is returned as it is.
  std::function<Expected<Mesh>(std::string_view bytes)> import;
  std::function<void(const Execution&)> during_import;
  /// Sees the further files of import().
  std::function<void(std::span<const ImportFile>)> files;
  std::size_t glb_padding = 0;  ///< extra bytes of the answer
};

class FakeEngine final : public FractureEngine {
 public:
  explicit FakeEngine(std::shared_ptr<FakeControl> control) : control_(std::move(control)) {}

  Expected<Mesh> import(std::span<const std::byte> bytes, MeshFormat, std::span<const ImportFile> files,
                        std::string_view, const ImportLimits&, const Execution& execution) const override {
    ++control_->imports;
    execution.poll();
    if (control_->files) control_->files(files);
    if (control_->during_import) control_->during_import(execution);
    if (control_->import)
      return control_->import({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    return Mesh{};
  }
  Expected<Solid> prepare(std::shared_ptr<const Mesh> mesh, const SolidOptions&,
                          const Execution&) const override {
    ++control_->prepares;
    Solid solid;
    solid.report.volume = 1;
    solid.source = std::move(mesh);
    return solid;
  }
  Expected<CutBase> base(const Solid&, const FractureParameters& parameters, const Selection&,
                         const Execution&) const override {
    ++control_->diagrams;
    Diagram diagram;
    diagram.sites.resize(parameters.sites);
    return diagram;
  }
  Expected<Cut> cut(const Solid&, const CutBase& base, const FractureParameters&, const Selection&,
                    const Execution& execution) const override {
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
    cut.fractured.set.certificate.fragments =
        static_cast<std::uint32_t>(std::get<Diagram>(base).sites.size());
    return cut;
  }
  /// A GLB or glTF whose JSON says what was asked; no geometry.
  GltfFile encode(const FracturedSolid& fractured, const GltfOptions& options, OutputFormat format,
                  const Execution&) const override {
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

 private:
  static GltfFile located(std::vector<std::uint8_t> file, OutputFormat format) {
    const TextRange figures = figures_in(file, format).value_or(TextRange());
    return {std::move(file), figures};
  }

  std::shared_ptr<FakeControl> control_;
};

}  // namespace fracture::test
