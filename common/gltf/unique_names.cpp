#include "common/gltf/unique_names.hpp"

#include <utility>

#include "common/base/pacer.hpp"

namespace fracture {

UniqueNames::UniqueNames(const SceneLayout& layout, std::size_t fragments, const Execution& execution) {
  Pacer pacer(execution);
  take("Fracture");
  for (std::size_t k = 0; k < fragments; ++k) {
    pacer.step(16);
    take(layout.name(k));
    for (std::size_t hull = 0; hull < layout.hulls(k); ++hull) {
      pacer.step(32);
      take(layout.hull_name(k, hull));
      take(layout.collider_name(k, hull));
    }
    if (layout.sheet_nodes(k) > 0) take(layout.sheet_name(k));
  }
}

bool UniqueNames::take(std::string name) { return taken_.insert(std::move(name)).second; }

std::string UniqueNames::add(std::string_view source, std::string_view suffix, std::size_t room) {
  const std::string first = kept_name(source, room - suffix.size()) + std::string(suffix);
  if (taken_.insert(first).second) return first;
  for (std::size_t& number = last_number_.try_emplace(first, 1).first->second;;) {
    const std::string end = "_" + std::to_string(++number) + std::string(suffix);
    std::string name = kept_name(source, room - end.size()) + end;
    if (taken_.insert(name).second) return name;
  }
}

}  // namespace fracture
