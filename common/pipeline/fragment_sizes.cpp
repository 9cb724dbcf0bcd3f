#include "common/pipeline/fragment_sizes.hpp"

#include "common/sites/arithmetic.hpp"

namespace fracture {

std::vector<double> fragment_sizes(std::uint32_t count, double spread, Pacer& pacer) {
  std::vector<double> sizes;
  sizes.reserve(count);
  double sum = 0;
  for (std::uint32_t k = 0; k < count; ++k) {
    pacer.step(64);
    const double larger = (count - k - 0.5) / count;  // fraction of fragments that are larger
    const double x = -sites_detail::logarithm(larger);
    sizes.push_back(x <= 1 ? sites_detail::power(x, spread) : 1 / sites_detail::power(1 / x, spread));
    sum += sizes.back();
  }
  for (double& size : sizes) size /= sum;
  return sizes;
}

}  // namespace fracture
