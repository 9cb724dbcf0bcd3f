// Makes one output: in this process, or through servers (remote_baker.hpp).
#pragma once

#include <functional>
#include <memory>
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

/// Why there is no output.
struct BakeFailure {
  enum class Kind {
    kRefused,      ///< the mesh or a parameter: it will be refused again
    kBroken,       ///< a bug, here or in the server, or lack of memory
    kUnsound,      ///< a bug too: the answer does not prove itself, and nobody gets it
    kCancelled,    ///< the stop came
    kUnavailable,  ///< the server is absent or busy beyond all patience: the other jobs will fare no better
  };
  Kind kind = Kind::kRefused;
  /// type, title, detail and, where one is concerned, parameter: as a server words it. Where more than one
  /// thing is wrong also errors, each with its detail.
  nlohmann::json problem;
  nlohmann::json certificate{};  ///< of what is unsound, as far as it is known

  BakeFailure(Kind given, nlohmann::json document) : kind(given), problem(std::move(document)) {}
  explicit BakeFailure(const Error& error);
  /// "mesh-not-closed: It is open."
  std::string words() const;
  /// The same with the title in a first line and everything else that is wrong in further ones.
  std::string all_words() const;
};

/// Thread-safe.
class Baker {
 public:
  virtual ~Baker() = default;
  virtual Expected<RequestParameters> parse(const std::vector<RawParameter>& given) = 0;
  virtual tl::expected<Baked, BakeFailure> bake(const FractureRequest& request,
                                                const Execution& execution) = 0;
  /// Where to say what goes on while a call takes long. Before the first call.
  virtual void on_notice(std::function<void(const std::string& line)>) {}
};

std::unique_ptr<Baker> local_baker(const ServiceConfig& config, int import_workers);
/// The same with another engine, for tests of what a sound one does not do.
std::unique_ptr<Baker> local_baker(const ServiceConfig& config, std::unique_ptr<FractureEngine> engine);

}  // namespace fracture::bake
