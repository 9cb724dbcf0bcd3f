// Makes names unique.
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
  /// Reserves the names of the fragments, hulls, colliders and sheets. Throws Interrupted.
  UniqueNames(const SceneLayout& layout, std::size_t fragments, const Execution& execution);

  /// Reserves a name. Returns whether it was free.
  bool take(std::string name);
  /// Returns kept_name() with `suffix`, at most `room` bytes. If it is taken, a number is inserted before the suffix:
  /// the lowest one from 2 on that makes the name unique.
  std::string add(std::string_view source, std::string_view suffix = {}, std::size_t room = kMaxName);

 private:
  std::set<std::string> taken_;
  std::map<std::string, std::size_t> last_number_;  ///< highest number that each name was given
};

}  // namespace fracture
