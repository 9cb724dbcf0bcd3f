// Access to the JSON of an answer, for answer.cpp and answer_materials.cpp.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/gltf/names.hpp"
#include "common/outputs/answer.hpp"

namespace fracture::outputs {

/// Thrown inside read_answer() if the bytes are not an answer.
struct Broken {
  std::string why;
};

/// The unsigned number object[key], or `fallback` if it is absent. A GLB has at most 4 GiB, so none of its
/// numbers is larger, and a sum of two does not overflow.
std::uint64_t number_at(const nlohmann::json& object, const char* key, std::uint64_t fallback);
inline constexpr std::uint64_t kHasToBeThere = ~std::uint64_t{0};  ///< fallback: throws Broken if absent

/// document[list][index]
const nlohmann::json& element(const nlohmann::json& document, const char* list, std::uint64_t index);

/// Makes names unique, without white space and control characters, whatever the answer contains, because they
/// are written in lines of text.
class Names {
 public:
  std::string add(std::string_view wanted) {
    std::string name = kept_name(wanted);
    for (std::size_t k = 2; !taken_.insert(name).second; ++k) {
      const std::string suffix = "_" + std::to_string(k);
      name = kept_name(wanted, kMaxName - suffix.size()) + suffix;
    }
    return name;
  }

 private:
  std::set<std::string> taken_;
};

/// Reads all materials. Throws Broken.
std::vector<Material> read_materials(const nlohmann::json& document, std::size_t images);

}  // namespace fracture::outputs
