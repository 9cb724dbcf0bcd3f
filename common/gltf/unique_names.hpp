// Names of which no two are equal.
#pragma once

#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <string_view>

#include "common/gltf/names.hpp"
#include "common/gltf/scene_layout.hpp"

namespace fracture {

class UniqueNames {
 public:
  /// The names of the fragments, hulls and colliders are taken. Throws Interrupted.
  UniqueNames(const SceneLayout& layout, std::size_t fragments, const Execution& execution);

  void take(std::string name);
  /// The name as ASCII with `suffix`, at most `room` bytes. If it is taken, with the lowest number from 2 on that makes it
  /// new before the suffix.
  std::string add(std::string_view source, std::string_view suffix = {}, std::size_t room = kMaxName);

 private:
  std::set<std::string> taken_;
  std::map<std::string, std::size_t> last_number_;  ///< that the same name was given
};

}  // namespace fracture
