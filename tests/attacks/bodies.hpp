// Request bodies of attackers: small on the wire, large once they are read.
#pragma once

#include <string>

#include "tests/server/support/requests.hpp"

namespace fracture::test {

inline const std::string kJson = "Content-Type: application/json\r\n",
                         kGltf = "Content-Type: model/gltf+json\r\n", kGzip = "Content-Encoding: gzip\r\n",
                         kForm = "Content-Type: multipart/form-data; boundary=B\r\n";

inline std::string many(const std::string& item, std::size_t count) {
  std::string text;
  text.reserve(item.size() * count);
  for (std::size_t k = 0; k < count; ++k) text += item;
  return text;
}

/// A form with a cube and these parameters.
inline std::string form_of(const std::string& params) {
  return "--B\r\nContent-Disposition: form-data; name=mesh; filename=a.obj\r\n\r\n" + kCube +
         "\r\n--B\r\nContent-Disposition: form-data; name=params\r\n\r\n" + params + "\r\n--B--\r\n";
}

/// One name `times` times, followed by the same name with a list of `length` numbers.
inline std::string repeated_parameters(std::size_t times, std::size_t length) {
  return form_of("{" + many("\"a\":0,", times) + "\"a\":[0" + many(",0", length) + "]}");
}

/// A tetrahedron whose node has the members `more`. Meshes with different `unique` differ only in that
/// number.
inline std::string gltf_with(const std::string& more, const std::string& material = "{}", int unique = 0) {
  return R"({"asset":{"version":"2.0","copyright":")" + std::to_string(unique) +
         R"("},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0)" + more +
         R"(}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}],"materials":[)" +
         material +
         R"(],"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},)"
         R"({"bufferView":1,"componentType":5121,"count":12,"type":"SCALAR"},)"
         R"({"componentType":5126,"count":900000,"type":"VEC3"}],)"
         R"("bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":12}],)"
         R"("buffers":[{"byteLength":60,"uri":"data:application/octet-stream;base64,)"
         R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAIBAAEDAAMCAQID"}]})";
}
/// 900,000 instances of four triangles each.
inline std::string gltf_of_many_instances(int unique) {
  return gltf_with(R"(,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":2}}})", "{}",
                   unique);
}

}  // namespace fracture::test
