#include "common/gltf/ue_collision.hpp"

namespace fracture {

void write_ucx_nodes(JsonText& json, std::size_t fragment, const SceneLayout& layout) {
  for (std::size_t hull = 0; hull < layout.ucx_nodes(fragment); ++hull) {
    json.begin_object().member("name", layout.hull_name(fragment, hull));
    json.member("mesh", layout.hull_mesh(fragment, hull)).end_object();
  }
}

}  // namespace fracture
