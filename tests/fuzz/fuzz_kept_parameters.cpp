// Fuzz target: the parameters of an answer as a cache keeps them, in text form. An accepted text is in its
// canonical form, which is read back unchanged, and a request could have contained it.
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
