// Fuzz target: the parameters that a cache has kept of an answer, as text. What is accepted is in its canonical form, which
// is read as itself; a request could have had it.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "common/parameters/parameter_object.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fracture;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto kept = read_kept_parameters(text);
  if (!kept) return 0;
  if (!are_parameters(*kept)) std::abort();
  const auto again = read_kept_parameters(kept->dump());
  if (!again || *again != *kept) std::abort();
  return 0;
}
