#include "common/outputs/answer.hpp"

#include <algorithm>

#include "common/gltf/container.hpp"
#include "common/mesh/frame.hpp"
#include "common/mesh/gltf_component.hpp"
#include "common/outputs/answer_document.hpp"

namespace fracture::outputs {

using nlohmann::json;

std::uint64_t number_at(const json& object, const char* key, std::uint64_t fallback) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 32;
  const auto at = object.find(key);
  if (at == object.end() && fallback != kHasToBeThere) return fallback;
  if (at == object.end() || !at->is_number_unsigned() || at->get<std::uint64_t>() > kMost)
    throw Broken{std::string("a '") + key + "' is not a number up to 2^32"};
  return at->get<std::uint64_t>();
}

const json& element(const json& document, const char* list, std::uint64_t index) {
  const auto at = document.find(list);
  if (at == document.end() || !at->is_array() || index >= at->size())
    throw Broken{std::string("there is no ") + list + "[" + std::to_string(index) + "]"};
  return (*at)[index];
}

namespace {

/// Selects the members to keep while parsing. Data that no other format shows is dropped: statistics, bonds,
/// sites and physics are most of the text.
class Wanted {
 public:
  bool operator()(int depth, json::parse_event_t event, const json& parsed) {
    // The material of a mesh may be nested as deeply as in its file (ImportLimits::max_json_depth), inside
    // lists of the answer.
    constexpr int kDeepest = 96;
    if (depth > kDeepest) throw Broken{"its text is nested too deeply"};
    if (event != json::parse_event_t::key) return true;
    const auto& key = parsed.get_ref<const std::string&>();
    if (depth == 1) list_ = key;
    if (depth == 1) return key != "extensions" && key != "extensionsUsed";
    if (list_ == "asset") return depth > 2 || key == "generator";
    if (list_ != "nodes") return true;
    if (depth == 3) return key != "extensions";
    return depth == 4 ? key == "fracture" : key == "id" || key == "source";  // of extras.fracture
  }

 private:
  std::string list_;
};

std::uint32_t u32_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  std::uint32_t value = 0;
  if (bytes.size() < at + sizeof value) throw Broken{"it ends within a header"};
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> glb) {
    if (u32_at(glb, 0) != 0x46546c67 || u32_at(glb, 4) != 2 || u32_at(glb, 8) != glb.size())
      throw Broken{"it is not a GLB of the stated length"};
    const std::size_t length = u32_at(glb, 12);
    if (glb.size() < kGlbText || length > glb.size() - kGlbText) throw Broken{"its text is cut off"};
    const std::uint8_t* const text = glb.data() + kGlbText;
    document_ = json::parse(text, text + length, Wanted(), /*allow_exceptions=*/false);
    if (!document_.is_object()) throw Broken{"its text is not JSON"};
    if (const std::size_t behind = kGlbText + length; behind < glb.size()) {
      buffer_ = glb.subspan(std::min(glb.size(), behind + 8));
      if (u32_at(glb, behind) > buffer_.size()) throw Broken{"its buffer is cut off"};
    }
  }

  Answer operator()() {
    answer_.generator = document_.at("asset").at("generator").get<std::string>();
    if (!answer_.generator.starts_with(kGenerator) ||
        answer_.generator.find_first_not_of("0123456789", std::strlen(kGenerator)) != std::string::npos)
      throw Broken{"it was not made by fracture"};
    read_images();
    answer_.materials = read_materials(document_, answer_.images.size());
    const auto nodes = document_.find("nodes");
    seen_.resize(nodes == document_.end() ? 0 : nodes->size());
    for (const json& root :
         element(document_, "scenes", number_at(document_, "scene", 0)).value("nodes", json::array()))
      walk(root.get<std::uint64_t>(), {});
    if (has_groups_) sort_by_node();
    return std::move(answer_);
  }

 private:
  /// Puts the objects into the order of their nodes, as in answers without groups.
  void sort_by_node() {
    std::vector<std::size_t> order(node_of_object_.size());
    for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return node_of_object_[a] < node_of_object_[b]; });
    std::vector<Object> sorted;
    sorted.reserve(order.size());
    for (const std::size_t k : order) sorted.push_back(std::move(answer_.objects[k]));
    answer_.objects = std::move(sorted);
  }

  void read_images() {
    if (!document_.contains("images")) return;
    for (const json& image : document_.at("images")) {
      const std::string type = image.at("mimeType").get<std::string>();
      const json& view = element(document_, "bufferViews", number_at(image, "bufferView", kHasToBeThere));
      const std::uint64_t at = number_at(view, "byteOffset", 0),
                          length = number_at(view, "byteLength", kHasToBeThere);
      if (at + length > buffer_.size()) throw Broken{"an image extends beyond its buffer"};
      const std::string name = type.starts_with("image/") ? kept_name(type.substr(6)) : "bin";
      answer_.images.push_back({"." + (name == "jpeg" ? "jpg" : name), buffer_.subspan(at, length)});
    }
  }

  /// Visits a node and its children. Parents only group their children: only the nodes of instances are rotated
  /// or scaled. Nodes of the source without a mesh are left out. An answer has two or three levels, and one more for each level
  /// of clusters (at most 8) or of groups (at most kMostSourceLevels, 64).
  void walk(std::uint64_t index, Vec3f place, int depth = 0, bool carried = false) {
    constexpr int kDeepest = 80;
    const json& node = element(document_, "nodes", index);
    if (seen_.at(index) || depth > kDeepest) throw Broken{"its nodes are not a tree"};
    seen_[index] = true;
    if (!node.contains("mesh") && !node.contains("children")) return;  // an empty node of the source
    const bool turned = node.contains("rotation") || node.contains("scale");
    if (node.contains("matrix")) throw Broken{"node " + std::to_string(index) + " has a matrix"};
    const auto by = node.find("translation");
    if (by != node.end() && depth == 0)
      answer_.offset = {by->at(0).get<double>(), by->at(1).get<double>(), by->at(2).get<double>()};
    else if (by != node.end())
      place = {place.x + by->at(0).get<float>(), place.y + by->at(1).get<float>(),
               place.z + by->at(2).get<float>()};
    const bool fragment = is_fragment(node);
    has_groups_ = has_groups_ || is_group(node);
    if (turned && !fragment) throw Broken{"node " + std::to_string(index) + " is turned or scaled"};
    if (node.contains("mesh")) {
      read_object(node, fragment, place);
      answer_.objects.back().carried = carried;
      node_of_object_.push_back(carried ? node_of_object_.back() : index);
      if (turned) answer_.objects.back().turned = similarity(node, place);
    }
    if (!node.contains("children")) return;
    for (const json& child : node.at("children")) {
      const std::uint64_t below = child.get<std::uint64_t>();
      if (fragment && !has_sheets(below)) continue;
      if (turned) throw Broken{"node " + std::to_string(index) + " is turned or scaled, and carries sheets"};
      walk(below, place, depth + 1, fragment);
    }
  }

  /// Whether a child of a fragment is its sheets. The others are for physics: colliders have no mesh of their own.
  bool has_sheets(std::uint64_t index) const {
    const json& node = element(document_, "nodes", index);
    return node.contains("mesh") && !node.value("name", "").starts_with("UCX_");
  }

  /// The transform of an instance's node, whose parents do not move it.
  static Similarity similarity(const json& node, Vec3f place) {
    Similarity at;
    at.move = to_double(place);
    if (const auto turn = node.find("rotation"); turn != node.end())
      for (std::size_t k = 0; k < 4; ++k) at.rotation[k] = turn->at(k).get<float>();
    if (const auto scale = node.find("scale"); scale != node.end()) {
      at.scale = scale->at(0).get<float>();
      if (scale->at(1).get<float>() != at.scale || scale->at(2).get<float>() != at.scale)
        throw Broken{"an instance is not scaled uniformly"};
    }
    return at;
  }

  static bool is_fragment(const json& node) {
    return node.contains("mesh") && node.contains("extras") && node.at("extras").contains("fracture") &&
           node.at("extras").at("fracture").contains("id");
  }

  static bool is_group(const json& node) {
    return !node.contains("mesh") && node.contains("extras") && node.at("extras").contains("fracture") &&
           node.at("extras").at("fracture").contains("source");
  }

  void read_object(const json& node, bool fragment, Vec3f place) {
    const json& mesh = element(document_, "meshes", number_at(node, "mesh", kHasToBeThere));
    Object object;
    object.name = names_.add(node.value("name", "mesh"));
    if (fragment) object.id = node.at("extras").at("fracture").at("id").get<std::uint64_t>();
    object.place = place;
    bool first = true;
    for (const json& primitive : mesh.at("primitives")) {
      read_attributes(primitive.at("attributes"), first, object);
      first = false;
      Primitive read{.indices = indices(number_at(primitive, "indices", kHasToBeThere))};
      if (primitive.contains("material")) read.material = number_at(primitive, "material", 0);
      if (read.material != kNoMaterial && read.material >= answer_.materials.size())
        throw Broken{"a mesh refers to material " + std::to_string(read.material)};
      if (read.indices.size() % 3 != 0) throw Broken{"a mesh does not consist of triangles"};
      for (std::size_t k = 0; k < read.indices.size(); ++k)
        if (read.indices[k] >= object.positions.size())
          throw Broken{"a triangle of " + object.name + " refers to a vertex that does not exist"};
      object.primitives.push_back(read);
    }
    if (mesh.contains("extensions") && mesh.at("extensions").contains("EXT_mesh_manifold"))
      read_merges(mesh.at("extensions").at("EXT_mesh_manifold"), object);
    answer_.objects.push_back(std::move(object));
  }

  void read_attributes(const json& attributes, bool first, Object& object) {
    const Floats positions = floats(number_at(attributes, "POSITION", kHasToBeThere), 3);
    if (!first) {
      if (positions != object.positions)
        throw Broken{"primitives of " + object.name + " do not share vertices"};
      return;
    }
    object.positions = positions;
    const auto add = [&](const std::string& name, std::size_t width) {
      if (!attributes.contains(name)) return Floats();
      const Floats values = floats(number_at(attributes, name.c_str(), 0), width);
      if (values.size() != positions.size())
        throw Broken{name + " of " + object.name + " has a different length"};
      return values;
    };
    object.normals = add("NORMAL", 3);
    object.colors = add("COLOR_0", 4);
    for (std::size_t set = 0; attributes.contains("TEXCOORD_" + std::to_string(set)); ++set)
      object.uvs.push_back(add("TEXCOORD_" + std::to_string(set), 2));
  }

  void read_merges(const json& extension, Object& object) {
    object.manifold = true;
    if (!extension.contains("mergeIndices")) return;  // no vertices are merged
    object.merge_corners = indices(number_at(extension, "mergeIndices", kHasToBeThere));
    object.merge_vertices = indices(number_at(extension, "mergeValues", kHasToBeThere));
    bool good = object.merge_corners.size() == object.merge_vertices.size();
    for (std::size_t k = 0; good && k < object.merge_corners.size(); ++k)
      good = object.merge_corners[k] < 3 * object.triangles() &&
             object.merge_vertices[k] < object.positions.size();
    if (!good)
      throw Broken{"EXT_mesh_manifold of " + object.name + " refers to something that does not exist"};
  }

  /// The position of an accessor's first element; each element has `size` bytes.
  const std::uint8_t* place_of(const json& accessor, std::size_t size, std::size_t& stride) const {
    const json& view = element(document_, "bufferViews", number_at(accessor, "bufferView", kHasToBeThere));
    const std::uint64_t count = number_at(accessor, "count", kHasToBeThere);
    stride = number_at(view, "byteStride", size);
    const std::uint64_t at = number_at(view, "byteOffset", 0) + number_at(accessor, "byteOffset", 0);
    if (stride < size || stride > 252 || count == 0 || at + (count - 1) * stride + size > buffer_.size())
      throw Broken{"an accessor extends beyond its buffer"};
    return buffer_.data() + at;
  }

  Floats floats(std::uint64_t index, std::size_t width) const {
    const json& accessor = element(document_, "accessors", index);
    static const char* const kTypes[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    if (accessor.at("componentType") != component_type::kFloat || accessor.at("type") != kTypes[width])
      throw Broken{"accessor " + std::to_string(index) + " is not a " + kTypes[width] + " of floats"};
    std::size_t stride = 0;
    const std::uint8_t* const first = place_of(accessor, width * sizeof(float), stride);
    return {first, number_at(accessor, "count", 0), width, stride};
  }

  Indices indices(std::uint64_t index) const {
    const json& accessor = element(document_, "accessors", index);
    const bool wide = accessor.at("componentType") == component_type::kUnsignedInt;
    if (!wide && accessor.at("componentType") != component_type::kUnsignedShort)
      throw Broken{"accessor " + std::to_string(index) + " does not contain indices"};
    std::size_t stride = 0;
    const std::size_t size = wide ? 4 : 2;
    const std::uint8_t* const first = place_of(accessor, size, stride);
    if (stride != size) throw Broken{"indices are not contiguous"};
    return {first, number_at(accessor, "count", 0), wide};
  }

  json document_;
  std::span<const std::uint8_t> buffer_;
  Answer answer_;
  Names names_;
  std::vector<bool> seen_;  ///< nodes
  bool has_groups_ = false;
  std::vector<std::uint64_t> node_of_object_;  ///< sheets have that of their fragment
};

}  // namespace

std::size_t Object::triangles() const {
  std::size_t sum = 0;
  for (const Primitive& primitive : primitives) sum += primitive.indices.size() / 3;
  return sum;
}

std::string Answer::offset_text() const {
  return offset == Vec3d{} ? std::string() : "offset " + to_text(offset);
}

std::size_t Answer::vertices() const {
  std::size_t sum = 0;
  for (const Object& object : objects) sum += object.positions.size();
  return sum;
}

std::size_t Answer::triangles() const {
  std::size_t sum = 0;
  for (const Object& object : objects) sum += object.triangles();
  return sum;
}

Expected<Answer> read_answer(std::span<const std::uint8_t> glb) {
  const auto broken = [](const std::string& why) {
    return fail(ErrorCode::kInternal, "The answer cannot be written as another file: " + why + ".");
  };
  try {
    return Reader(glb)();
  } catch (const Broken& fault) {
    return broken(fault.why);
  } catch (const json::exception& fault) {
    return broken(fault.what());
  }
}

}  // namespace fracture::outputs
