// Computes one output: in this process, or through servers (remote_baker.hpp).
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
  StageTimings timings{};  ///< only set if computed in this process
};

/// Parses the parameters of a bake by the baker's table. Returns kNoSuchAnswer if `of` is given, because a
/// baker keeps no earlier answers.
Expected<RequestParameters> parse_parameters(const ParameterTable& table,
                                             const std::vector<RawParameter>& given);

/// Thread-safe.
class Baker {
 public:
  virtual ~Baker() = default;
  virtual Expected<RequestParameters> parse(const std::vector<RawParameter>& given) = 0;
  /// Computes one output. failure.hpp says what becomes of a job after each error. `stop` cancels the
  /// computation or the wait for a server. `execution` applies only to computations on this machine.
  virtual Expected<Baked> bake(const FractureRequest& request, const Execution& execution,
                               const std::stop_token& stop) = 0;
  /// Sets the function that receives messages during long calls. Must be called before the first bake().
  virtual void on_notice(std::function<void(const std::string& line)>) {}
};

/// A baker that computes in this process.
std::unique_ptr<Baker> local_baker(const ServiceConfig& config, std::unique_ptr<FractureEngine> engine);

}  // namespace fracture::bake
