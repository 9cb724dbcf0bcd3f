// Turns bytes into a mesh and parameters, so that a fuzzer that changes bytes changes the structure of both.
// The bytes choose families and sizes of shapes, their arrangement, damage, scale and position, and, through
// the table of parameters, any value that a request may contain.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "common/mesh/mesh.hpp"
#include "common/parameters/parameters.hpp"

namespace fracture::fuzz {

/// A source of choices. After the last byte every choice is the first one, so short inputs are simple.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : at_(data), end_(data + size) {}

  std::uint8_t byte() { return at_ == end_ ? 0 : *at_++; }
  std::uint64_t word();
  /// In [0, n), n > 0.
  std::uint32_t below(std::uint32_t n);
  /// In [0, 1], a multiple of 1/65535, including both ends.
  double unit();
  double between(double low, double high) { return low + unit() * (high - low); }
  bool once_in(std::uint32_t n) { return below(n) == n - 1; }

 private:
  const std::uint8_t *at_, *end_;
};

struct FractureCase {
  Mesh mesh;
  RequestParameters parameters;
  /// With `parameters.fracture`: the index of the fragment in the answer that is fractured again, modulo
  /// their number.
  std::uint32_t refracture = 0;
  bool has_refracture = false;
  std::string shape;       ///< how the mesh was made, for people
  nlohmann::json request;  ///< the parameters as a request would contain them
};

/// Always makes a case: members that the table refuses are left out of the request.
FractureCase decode_case(const std::uint8_t* data, std::size_t size);

/// Returns a Wavefront OBJ. Each coordinate has enough digits to restore its float.
std::string to_obj(const Mesh& mesh);

}  // namespace fracture::fuzz
