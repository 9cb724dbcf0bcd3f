#include "client/world/fragments.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <string>

#include "common/import/gltf_accessor.hpp"
#include "common/import/gltf_document.hpp"
#include "common/import/gltf_model.hpp"
#include "common/import/refused.hpp"

namespace fracture::world {
namespace {

using nlohmann::json;

constexpr const char* kExtension = "KHR_physics_rigid_bodies";

[[noreturn]] void malformed(const std::string& what) { refuse(ErrorCode::kMalformedMesh, what); }

const json& member(const json& object, const char* key, const std::string& where) {
  const auto it = object.is_object() ? object.find(key) : object.end();
  if (!object.is_object() || it == object.end()) malformed(where + " has no " + key + ".");
  return *it;
}

const json* find(const json& object, const char* key) {
  if (!object.is_object()) return nullptr;
  const auto it = object.find(key);
  return it == object.end() ? nullptr : &*it;
}

double number(const json& value, const std::string& where) {
  if (!value.is_number()) malformed(where + " is not a number.");
  const double x = value.get<double>();
  if (!std::isfinite(x)) refuse(ErrorCode::kNotFinite, where + " is not finite.");
  return x;
}

double positive(const json& object, const char* key, const std::string& where) {
  const double x = number(member(object, key, where), where + "." + key);
  if (!(x > 0)) malformed(where + "." + key + " is " + std::to_string(x) + "; it must be more than 0.");
  return x;
}

template <int N>
std::array<double, N> numbers(const json& value, const std::string& where) {
  if (!value.is_array() || value.size() != N)
    malformed(where + " is not an array of " + std::to_string(N) + " numbers.");
  std::array<double, N> x;
  for (std::size_t k = 0; k < N; ++k) x[k] = number(value[k], where);
  return x;
}

glm::dvec3 vector(const json& value, const std::string& where) {
  const auto x = numbers<3>(value, where);
  return {x[0], x[1], x[2]};
}

std::uint64_t whole(const json& value, const std::string& where) {
  if (!value.is_number_unsigned()) malformed(where + " must be a whole number of 0 or more.");
  return value.get<std::uint64_t>();
}

const json* physics_of(const json& node) {
  const json* extensions = find(node, "extensions");
  return extensions ? find(*extensions, kExtension) : nullptr;
}

glm::dvec3 to_world(const Transform& t, double x, double y, double z) {
  return {t.t.x + x * t.x.x + y * t.y.x + z * t.z.x, t.t.y + x * t.x.y + y * t.y.y + z * t.z.y,
          t.t.z + x * t.x.z + y * t.y.z + z * t.z.z};
}

/// Returns the rotation. The transform must be rigid apart from a uniform scale, which only nodes of instances have. Hulls are
/// scaled, but mass and moments are not (KHR_physics_rigid_bodies).
glm::dquat rotation_of(const Transform& t, const std::string& where) {
  glm::dmat3 r(t.x.x, t.x.y, t.x.z, t.y.x, t.y.y, t.y.z, t.z.x, t.z.y, t.z.z);
  const double scale = glm::length(r[0]);
  if (!(scale > 0)) malformed(where + " is flat.");
  r = (1 / scale) * r;
  const glm::dmat3 unit = glm::transpose(r) * r - glm::dmat3(1);
  for (int c = 0; c < 3; ++c)
    if (!(glm::length(unit[c]) < 1e-6)) malformed(where + " is sheared, or its axes are scaled differently.");
  if (glm::determinant(r) < 0) malformed(where + " is mirrored.");
  return glm::normalize(glm::quat_cast(r));
}

class FragmentReader {
 public:
  FragmentReader(const json& document, const tinygltf::Model& model, const json& surfaces)
      : document_(document), model_(model), surfaces_(surfaces) {}

  FragmentSet read() {
    const json& root = read_nodes();
    read_filtered(root);
    std::vector<FragmentChange::End> ends;
    if (root.contains("bonds")) read_bonds(root["bonds"], root_, set_.bonds, ends);
    for (std::size_t k = 0; k < ends.size(); ++k) {
      set_.bonds[k].a = index_of(ends[k].a);
      set_.bonds[k].b = index_of(ends[k].b);
    }
    read_surface();
    return std::move(set_);
  }

  FragmentChange read_change() {
    const json& root = read_nodes();
    read_filtered(root);
    FragmentChange change;
    const json& delta = member(root, "delta", "extras.fracture");
    const auto ids = [&](const char* key) {
      const std::string where = std::string("extras.fracture.delta.") + key;
      const json& list = member(delta, key, "extras.fracture.delta");
      if (!list.is_array()) malformed(where + " is not an array.");
      std::vector<std::uint64_t> result;
      for (const json& id : list) result.push_back(whole(id, where));
      return result;
    };
    change.added = ids("new");
    change.changed = ids("changed");
    change.gone = ids("gone");
    for (const auto* list : {&change.added, &change.changed})
      for (const std::uint64_t id : *list) index_of(id);
    if (change.added.size() + change.changed.size() != set_.fragments.size())
      malformed("The answer to a hit has " + std::to_string(set_.fragments.size()) + " fragments but lists " +
                std::to_string(change.added.size() + change.changed.size()) + " as new or changed.");
    read_bonds(member(root, "bonds", "extras.fracture"), root_, change.bonds, change.ends);
    change.fragments = std::move(set_.fragments);
    return change;
  }

 private:
  /// Reads the fragments, and returns the extras of the root.
  const json& read_nodes() {
    static const json kNothing = json::object();
    const GltfScene graph = walk_gltf_scene(model_);
    const json* root = nullptr;
    for (const int index : graph.order) {
      const json& node = document_.at("nodes").at(static_cast<std::size_t>(index));
      const json* extras = find(node, "extras");
      const json* own = extras ? find(*extras, "fracture") : nullptr;
      if (own == nullptr) continue;
      if (own->contains("bonds")) {
        root = own;
        root_ = *graph.world[static_cast<std::size_t>(index)];
      }
      if (own->contains("id")) read_fragment(node, *own, graph, index);
    }
    if (set_.fragments.empty())
      refuse(ErrorCode::kNoFragments, "The file has no node with extras.fracture.id.");
    return root != nullptr ? *root : kNothing;
  }

  void read_fragment(const json& node, const json& own, const GltfScene& graph, int index) {
    if (set_.fragments.size() >= kMaxFragments)
      refuse(ErrorCode::kTooLarge, "The file has more than " + std::to_string(kMaxFragments) + " fragments.");
    const std::string where = "Node " + std::to_string(index);
    Fragment fragment;
    fragment.id = whole(own.at("id"), where + ".extras.fracture.id");
    fragment.volume = positive(own, "volume", where + ".extras.fracture");
    const json* anchored = find(own, "anchored");
    fragment.anchored = anchored != nullptr && anchored->is_boolean() && anchored->get<bool>();
    const auto [at, is_new] =
        index_.try_emplace(fragment.id, static_cast<std::uint32_t>(set_.fragments.size()));
    if (!is_new) malformed("Two fragments have the id " + std::to_string(fragment.id) + ".");
    const json* body = physics_of(node);
    if (body == nullptr) malformed(where + " is a fragment without " + kExtension + ".");
    const Transform& world = *graph.world[static_cast<std::size_t>(index)];
    const json& motion = member(*body, "motion", where + "." + kExtension);
    const std::string in_motion = where + ".motion";
    const double mass = positive(motion, "mass", in_motion);
    const glm::dvec3 center = vector(member(motion, "centerOfMass", in_motion), in_motion + ".centerOfMass");
    const glm::dvec3 moments =
        vector(member(motion, "inertiaDiagonal", in_motion), in_motion + ".inertiaDiagonal");
    if (!(moments.x > 0 && moments.y > 0 && moments.z > 0))
      malformed(in_motion + ".inertiaDiagonal must be more than 0.");
    const auto q =
        numbers<4>(member(motion, "inertiaOrientation", in_motion), in_motion + ".inertiaOrientation");
    const double norm = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    if (!(std::abs(norm - 1) < 1e-3)) malformed(in_motion + ".inertiaOrientation must be a unit quaternion.");
    const glm::dquat turn = rotation_of(world, where) * glm::normalize(glm::dquat(q[3], q[0], q[1], q[2]));
    const glm::dmat3 axes = glm::mat3_cast(turn);
    fragment.mass.mass = mass;
    fragment.mass.center = to_world(world, center.x, center.y, center.z);
    fragment.mass.inertia =
        axes * glm::dmat3(moments.x, 0, 0, 0, moments.y, 0, 0, 0, moments.z) * glm::transpose(axes);
    read_collider(node, world, fragment);
    for (const int child : at_index(index).children)
      read_collider(document_.at("nodes").at(static_cast<std::size_t>(child)),
                    *graph.world[static_cast<std::size_t>(child)], fragment);
    if (fragment.hulls.empty()) malformed(where + " is a fragment without a convex hull.");
    set_.fragments.push_back(std::move(fragment));
  }

  const tinygltf::Node& at_index(int index) const { return at(model_.nodes, index, "node"); }

  void read_collider(const json& node, const Transform& world, Fragment& fragment) {
    const json* body = physics_of(node);
    const json* collider = body ? find(*body, "collider") : nullptr;
    if (collider == nullptr) return;
    const json& geometry = member(*collider, "geometry", "A collider");
    const std::uint64_t mesh = whole(member(geometry, "mesh", "A collider's geometry"), "A collider's mesh");
    if (mesh >= model_.meshes.size())
      malformed("A collider refers to mesh " + std::to_string(mesh) + ", but the file has only " +
                std::to_string(model_.meshes.size()) + " meshes.");
    Hull hull;
    for (const tinygltf::Primitive& primitive : model_.meshes[mesh].primitives) {
      const auto position = primitive.attributes.find("POSITION");
      if (position == primitive.attributes.end()) malformed("A hull has no POSITION.");
      const std::vector<double> xyz = read_accessor(model_, position->second, 3);
      for (std::size_t k = 0; k + 2 < xyz.size(); k += 3) {
        if (!std::isfinite(xyz[k] + xyz[k + 1] + xyz[k + 2]))
          refuse(ErrorCode::kNotFinite, "A point of hull " + std::to_string(mesh) + " is not finite.");
        hull.push_back(to_world(world, xyz[k], xyz[k + 1], xyz[k + 2]));
      }
      if (primitive.indices >= 0)
        for (const std::uint32_t v : read_indices(model_, primitive.indices))
          if (v >= xyz.size() / 3)
            malformed("A triangle of hull " + std::to_string(mesh) +
                      " refers to a point that does not exist.");
    }
    if (hull.size() < 4) malformed("Hull " + std::to_string(mesh) + " has fewer than four points.");
    fragment.hulls.push_back(std::move(hull));
  }

  std::uint32_t index_of(std::uint64_t id) const {
    const auto it = index_.find(id);
    if (it == index_.end())
      malformed("A bond or a hit refers to fragment " + std::to_string(id) + ", which does not exist.");
    return it->second;
  }

  /// In a delta one of the two may be a fragment of the earlier answer.
  void read_filtered(const json& root) {
    const json* filtered = find(root, "filtered");
    if (filtered == nullptr) return;
    const json &a = member(*filtered, "a", "filtered"), &b = member(*filtered, "b", "filtered");
    if (!a.is_array() || !b.is_array() || a.size() != b.size())
      malformed("The columns of extras.fracture.filtered must be arrays of the same length.");
    const auto note = [&](std::uint64_t id, std::uint64_t other) {
      if (const auto at = index_.find(id); at != index_.end())
        set_.fragments[at->second].apart.push_back(other);
    };
    for (std::size_t k = 0; k < a.size(); ++k) {
      const std::uint64_t x = whole(a[k], "filtered.a"), y = whole(b[k], "filtered.b");
      note(x, y);
      note(y, x);
    }
    for (Fragment& fragment : set_.fragments) std::sort(fragment.apart.begin(), fragment.apart.end());
  }

  /// `above`: the transform of the root node. Places in its extras are below it.
  static void read_bonds(const json& bonds, const Transform& above, std::vector<Bond>& read,
                         std::vector<FragmentChange::End>& ends) {
    const json &a = member(bonds, "a", "bonds"), &b = member(bonds, "b", "bonds"),
               &area = member(bonds, "area", "bonds"), &strength = member(bonds, "strength", "bonds"),
               &normal = member(bonds, "normal", "bonds"), &center = member(bonds, "centroid", "bonds");
    for (const json* column : {&a, &b, &area, &strength, &normal, &center})
      if (!column->is_array() || column->size() != a.size())
        malformed("The columns of the bonds must be arrays of the same length.");
    read.reserve(a.size());
    ends.reserve(a.size());
    for (std::size_t k = 0; k < a.size(); ++k) {
      ends.push_back({whole(a[k], "An end of a bond"), whole(b[k], "An end of a bond")});
      const glm::dvec3 place = vector(center[k], "bonds.centroid");
      Bond bond{.area = number(area[k], "bonds.area"),
                .strength = number(strength[k], "bonds.strength"),
                .normal = vector(normal[k], "bonds.normal"),
                .center = place + glm::dvec3(above.t.x, above.t.y, above.t.z)};
      if (ends.back().a == ends.back().b) malformed("A bond connects a fragment to itself.");
      if (bond.area < 0 || bond.strength < 0) malformed("A bond's area and strength must be 0 or more.");
      const double length = glm::length(bond.normal);
      bond.normal = length > 1e-9 ? bond.normal / length : glm::dvec3(0);
      read.push_back(bond);
    }
  }

  /// Reads the one physics material that the service writes for all fragments.
  void read_surface() {
    const json* extensions = find(surfaces_, "extensions");
    const json* own = extensions ? find(*extensions, kExtension) : nullptr;
    const json* materials = own ? find(*own, "physicsMaterials") : nullptr;
    if (materials == nullptr || !materials->is_array() || materials->empty()) return;
    const json& material = materials->front();
    if (const json* x = find(material, "dynamicFriction")) set_.friction = number(*x, "dynamicFriction");
    if (const json* x = find(material, "restitution")) set_.restitution = number(*x, "restitution");
    if (set_.friction < 0 || set_.restitution < 0 || set_.restitution > 1)
      malformed("The physics material must have a friction of 0 or more and a restitution from 0 to 1.");
  }

  const json& document_;
  const tinygltf::Model& model_;
  const json& surfaces_;
  FragmentSet set_;
  std::map<std::uint64_t, std::uint32_t> index_;
  Transform root_;  // of the node with the figures
};

/// The document's own extensions, which the checked document omits. The container has been checked, so its
/// first chunk is JSON.
json document_extensions(std::span<const std::byte> glb) {
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, 4);
  const char* const text = reinterpret_cast<const char*>(glb.data()) + 20;
  return json::parse(text, text + length, [](int depth, json::parse_event_t event, json& parsed) {
    return depth != 1 || event != json::parse_event_t::key || parsed == "extensions";
  });
}

/// Calls `read` with a FragmentReader of the file.
template <class Result, class Read>
Expected<Result> read_with(std::span<const std::byte> glb, const Read& read) {
  try {
    GltfDocument document = read_gltf_document(glb, MeshFormat::kGlb, ImportLimits{}, {});
    if (!document.json.contains("nodes")) refuse(ErrorCode::kNoFragments, "The glTF has no nodes.", "/nodes");
    const tinygltf::Model model = load_gltf_model(document);
    const json surfaces = document_extensions(glb);
    return read(FragmentReader(document.json, model, surfaces));
  } catch (const Refused& refused) {
    return tl::unexpected<Error>(refused.error);
  } catch (const json::exception& error) {
    return fail(ErrorCode::kMalformedMesh,
                std::string("The glTF has a value of the wrong type: ") + error.what() + ".");
  }
}

}  // namespace

Expected<FragmentSet> read_fragments(std::span<const std::byte> glb) {
  return read_with<FragmentSet>(glb, [](FragmentReader reader) { return reader.read(); });
}

Expected<FragmentChange> read_change(std::span<const std::byte> glb) {
  return read_with<FragmentChange>(glb, [](FragmentReader reader) { return reader.read_change(); });
}

}  // namespace fracture::world
