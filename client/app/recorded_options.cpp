#include "client/app/recorded_options.hpp"

#include <cstdio>

#include "client/app/output_places.hpp"
#include "common/base/json_text.hpp"
#include "common/base/printable.hpp"

namespace fracture::app {

using nlohmann::json;

json header_of(const Options& options, const scenes::Scene& scene) {
  return {{"scene", options.scene},           {"files", options.files},
          {"material", options.material},     {"unit", options.unit},
          {"parameters", options.parameters}, {"seed", options.seed},
          {"anticipate", options.anticipate}, {"digest", scenes::digest_of(scene)}};
}

Expected<Options> with_header(Options options, const json& header) {
  try {
    header.at("scene").get_to(options.scene);
    header.at("files").get_to(options.files);
    header.at("material").get_to(options.material);
    header.at("unit").get_to(options.unit);
    options.parameters = header.at("parameters");
    header.at("seed").get_to(options.seed);
    header.at("anticipate").get_to(options.anticipate);
  } catch (const json::exception& error) {
    return fail(ErrorCode::kBadJson, "The header of the recorded game has no valid scene or settings: " +
                                         json_trouble(error) + ".");
  }
  return options;
}

Expected<std::shared_ptr<const game::Recording>> recording_for(Options& options, const std::string& path) {
  Expected<game::Recording> recording = game::read_recording(path);
  if (!recording) return tl::unexpected(recording.error());
  Expected<Options> begun = with_header(options, recording->header);
  if (!begun) return tl::unexpected(begun.error());
  options = std::move(*begun);
  if (recording->cut_off)
    std::fprintf(
        stderr,
        "fracture-client: %s ends in the middle of a line; only the %zu steps before that line are played\n",
        printable(path).c_str(), recording->hashes.size());
  if (const std::optional<std::string> lost = same_place(options))  // again, with the recording's meshes
    return fail(ErrorCode::kFileAccess, *lost);
  return std::make_shared<const game::Recording>(std::move(*recording));
}

Expected<void> check_scene(const json& header, const scenes::Scene& scene) {
  // Old recordings have no digest. They are played, and a step that differs is reported.
  const auto digest = header.find("digest");
  if (digest == header.end() || *digest == scenes::digest_of(scene)) return {};
  return fail(
      ErrorCode::kBadParameter,
      "The recorded scene '" + scene.name +
          "' differs from this program's scene. A mesh has changed, or another version recorded the game.");
}

Expected<std::shared_ptr<game::Recorder>> recorder_for(const std::string& path, const json& header) {
  if (path.empty()) return std::shared_ptr<game::Recorder>();
  auto recorder = game::Recorder::create(path, header);
  if (!recorder) return tl::unexpected(recorder.error());
  return std::make_shared<game::Recorder>(std::move(*recorder));
}

}  // namespace fracture::app
