#include "server/bake/baker.hpp"
#include "server/service/service.hpp"

namespace fracture::bake {
namespace {

class LocalBaker : public Baker {
 public:
  LocalBaker(const ServiceConfig& config, std::unique_ptr<FractureEngine> engine)
      : service_(config, std::move(engine)) {}

  Expected<RequestParameters> parse(const std::vector<RawParameter>& given) override {
    return parse_parameters(service_.parameters(), given);
  }

  Expected<Baked> bake(const FractureRequest& request, const Execution& execution,
                       const std::stop_token& stop) override {
    Execution stoppable = execution;
    stoppable.stop = stop;
    const Expected<FractureAnswer> answer = service_.fracture(request, stoppable);
    if (!answer) return tl::unexpected<Error>(answer.error());
    const std::shared_ptr<const FractureResult>& result = answer->result;
    return Baked{{result, &result->file}, result->file_digest, result->summary.value(), answer->timings};
  }

 private:
  FractureService service_;
};

}  // namespace

std::unique_ptr<Baker> local_baker(const ServiceConfig& config, std::unique_ptr<FractureEngine> engine) {
  return std::make_unique<LocalBaker>(config, std::move(engine));
}

}  // namespace fracture::bake
