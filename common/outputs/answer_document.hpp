// The JSON of an answer: how answer.cpp and answer_materials.cpp take it apart.
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

/// Thrown inside of read_answer() where the bytes are no answer.
struct Broken {
  std::string why;
};

/// The unsigned number object[key]; `fallback` where it is absent. A GLB has no more than 4 GiB, so that none of its
/// numbers is larger and no sum of two overflows.
std::uint64_t number_at(const nlohmann::json& object, const char* key, std::uint64_t fallback);
inline constexpr std::uint64_t kHasToBeThere = ~std::uint64_t{0};  ///< as a fallback

/// document[list][index]
const nlohmann::json& element(const nlohmann::json& document, const char* list, std::uint64_t index);

/// Names of which no two are equal, of letters, digits and _, whatever the answer says: they stand in lines of text.
class Names {
 public:
  std::string add(std::string_view wanted) {
    std::string name = ascii_name(wanted);
    for (std::size_t k = 2; !taken_.insert(name).second; ++k) {
      const std::string suffix = "_" + std::to_string(k);
      name = ascii_name(wanted, kMaxName - suffix.size()) + suffix;
    }
    return name;
  }

 private:
  std::set<std::string> taken_;
};

/// Throws Broken.
std::vector<Material> read_materials(const nlohmann::json& document, std::size_t images);

}  // namespace fracture::outputs
