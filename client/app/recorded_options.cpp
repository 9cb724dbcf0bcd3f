#include "client/app/recorded_options.hpp"

namespace fracture::app {

using nlohmann::json;

json header_of(const Options& options) {
  return {{"scene", options.scene},           {"files", options.files},
          {"material", options.material},     {"unit", options.unit},
          {"parameters", options.parameters}, {"seed", options.seed},
          {"anticipate", options.anticipate}};
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
    return fail(ErrorCode::kBadJson,
                "The recorded game does not say how it began: " + std::string(error.what()));
  }
  return options;
}

Expected<std::shared_ptr<game::Recorder>> recorder_for(const Options& options) {
  if (options.log.empty()) return std::shared_ptr<game::Recorder>();
  auto recorder = game::Recorder::create(options.log, header_of(options));
  if (!recorder) return tl::unexpected(recorder.error());
  return std::make_shared<game::Recorder>(std::move(*recorder));
}

}  // namespace fracture::app
