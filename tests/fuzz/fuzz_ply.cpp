// Fuzz target: a whole PLY file. Each result is a consistent Mesh or an Error with a sentence.
#include "tests/fuzz/check_import.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fracture::test::check_import(data, size, fracture::MeshFormat::kPly);
  return 0;
}
