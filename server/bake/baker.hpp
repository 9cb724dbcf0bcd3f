// Makes one output: in this process, or through servers.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/base/execution.hpp"
#include "server/service/service.hpp"

namespace fracture::bake {

struct Baked {
  std::shared_ptr<const std::vector<std::uint8_t>> file;
  Digest digest;           ///< of the file
  nlohmann::json figures;  ///< extras.fracture of the file: report, certificate, bonds
};

/// Thread-safe. All bad input, cancellation and what a server says of them come back as errors.
class Baker {
 public:
  virtual ~Baker() = default;
  virtual Expected<RequestParameters> parse(const std::vector<RawParameter>& given) = 0;
  virtual Expected<Baked> bake(const FractureRequest& request, const Execution& execution) = 0;
};

std::unique_ptr<Baker> local_baker(const ServiceConfig& config, int import_workers);

}  // namespace fracture::bake
