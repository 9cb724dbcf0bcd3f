// Makes one output: in this process, or through servers (remote_baker.hpp).
#pragma once

#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "common/base/execution.hpp"
#include "server/service/service.hpp"

namespace fracture::bake {

struct Baked {
  std::shared_ptr<const std::vector<std::uint8_t>> file;
  Digest digest;  ///< of the file
  AnswerSummary summary;
  StageTimings timings{};  ///< where it was made here
};

/// Of a bake, by the table of its baker: kNoSuchAnswer for `of`, because no baker keeps answers.
Expected<RequestParameters> parse_parameters(const ParameterTable& table,
                                             const std::vector<RawParameter>& given);

/// Thread-safe.
class Baker {
 public:
  virtual ~Baker() = default;
  virtual Expected<RequestParameters> parse(const std::vector<RawParameter>& given) = 0;
  /// What an error comes to: failure.hpp.
  /// `stop` ends it, its waits for a server too. `execution`: what else a computation on this machine heeds.
  virtual Expected<Baked> bake(const FractureRequest& request, const Execution& execution,
                               const std::stop_token& stop) = 0;
  /// Where to say what goes on while a call takes long. Before the first call.
  virtual void on_notice(std::function<void(const std::string& line)>) {}
};

/// In this process.
std::unique_ptr<Baker> local_baker(const ServiceConfig& config, std::unique_ptr<FractureEngine> engine);

}  // namespace fracture::bake
