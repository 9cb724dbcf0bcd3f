#include "common/gltf/gltf_writer.hpp"

#include <algorithm>
#include <span>
#include <string>

#include "common/base/pacer.hpp"
#include "common/gltf/accessors.hpp"
#include "common/gltf/cluster_nodes.hpp"
#include "common/gltf/container.hpp"
#include "common/gltf/empty_nodes.hpp"
#include "common/gltf/fracture_extras.hpp"
#include "common/gltf/group_nodes.hpp"
#include "common/gltf/image_bytes.hpp"
#include "common/gltf/intact_scene.hpp"
#include "common/gltf/json_text.hpp"
#include "common/gltf/khr_physics.hpp"
#include "common/gltf/mesh_writer.hpp"
#include "common/gltf/omi_physics.hpp"
#include "common/gltf/passed_through.hpp"
#include "common/gltf/scene_layout.hpp"
#include "common/gltf/ue_collision.hpp"
#include "common/mesh/material_library.hpp"

namespace fracture {
namespace {

void check_companions(const FracturedSolid& fractured) {
  for (const std::size_t size :
       {fractured.hulls.of_fragment.size(), fractured.anchored.held.size(),
        fractured.hierarchy.cluster_of_fragment.size(), fractured.instances.of_fragment.size()})
    if (size != 0 && size != fractured.set.fragments.size())
      throw InternalError("data for " + std::to_string(size) + " fragments in a set of " +
                          std::to_string(fractured.set.fragments.size()));
}

void write_asset(JsonText& json, const FragmentSet& set, const GltfOptions& options) {
  json.key("asset").begin_object().member("version", "2.0");
  json.member("generator", "fracture, algorithm " + std::to_string(options.algorithm));
  if (!set.source->copyright.empty()) json.member("copyright", set.source->copyright);
  json.key("extras").begin_object().member("parameters", options.parameters);
  if (!options.mesh_digest.empty()) json.member("mesh", options.mesh_digest);
  json.end_object().end_object();
}

void write_string_array(JsonText& json, std::string_view key, const std::vector<std::string>& values) {
  if (values.empty()) return;
  json.key(key).begin_array();
  for (const std::string& value : values) json.value(value);
  json.end_array();
}

/// Writes the source's material extensions, then our own that occur in the file.
void write_extensions_used(JsonText& json, const FragmentSet& set, const GltfOptions& options,
                           const SceneLayout& layout) {
  std::vector<std::string> used = set.source->library->extensions_used;
  bool manifold = false;
  for (const Fragment& f : set.fragments)
    manifold = manifold || (options.mesh_manifold && !f.topology.empty());
  if (manifold) used.emplace_back("EXT_mesh_manifold");
  if (!set.fragments.empty() && options.physics == Physics::kKhr)
    used.emplace_back("KHR_physics_rigid_bodies");
  if (!set.fragments.empty() && options.physics == Physics::kOmi) {
    used.emplace_back("OMI_physics_body");
    if (layout.has_hulls()) used.emplace_back("OMI_physics_shape");
  }
  write_string_array(json, "extensionsUsed", used);
}

void write_document_extensions(JsonText& json, const FragmentSet& set, const GltfOptions& options,
                               const SceneLayout& layout, const IntactScene& intact) {
  const bool fragments = !set.fragments.empty(), khr = fragments && options.physics == Physics::kKhr,
             omi = fragments && options.physics == Physics::kOmi && layout.has_hulls();
  const auto& variants = set.source->library->variants;
  if (!khr && !omi && variants.empty()) return;
  json.key("extensions").begin_object();
  if (!variants.empty())
    json.key("KHR_materials_variants").begin_object().member("variants", variants).end_object();
  if (khr) write_khr_physics_document(json, layout, options);
  if (omi) write_omi_physics_document(json, layout, intact);
  json.end_object();
}

/// Returns the position of the root's `extras.fracture` object in the text.
TextRange write_root(JsonText& json, const FracturedSolid& fractured, const GltfOptions& options,
                     const std::vector<std::size_t>& children) {
  json.begin_object().member("name", "Fracture");
  write_offset(json, *fractured.set.source);
  if (!fractured.set.fragments.empty()) {
    json.key("children").begin_array();
    for (const std::size_t node : children) json.value(node);
    json.end_array();
  }
  json.key("extras").begin_object().key("fracture");
  const std::size_t begin = json.text().size();
  write_root_extras(json, fractured, options);
  const TextRange figures{begin, json.text().size() - begin};
  json.end_object().end_object();
  return figures;
}

/// Writes the transform of a fragment's node. Only those of instances rotate or scale.
void write_place(JsonText& json, const Fragment& f, const InstancedBodies::Body* instance) {
  const Vec3d& translation = instance == nullptr ? f.pivot : instance->translation;
  if (!(translation == Vec3d{})) json.member("translation", translation);
  if (instance == nullptr) return;
  if (instance->is_turned()) {
    json.key("rotation").begin_array();
    for (const float component : instance->rotation) json.rounded(component);
    json.end_array();
  }
  if (instance->scale != 1) {
    json.key("scale").begin_array();
    for (int axis = 0; axis < 3; ++axis) json.rounded(instance->scale);
    json.end_array();
  }
}

void write_fragment(JsonText& json, const FracturedSolid& fractured, std::size_t index,
                    const GltfOptions& options, const SceneLayout& layout, const SourceOfFragments& sources) {
  const Fragment& f = fractured.set.fragments[index];
  json.begin_object().member("name", layout.name(index)).member("mesh", layout.mesh(index));
  if (layout.children(index) > 0) {
    json.key("children").begin_array();
    for (std::size_t k = 0; k < layout.children(index); ++k) json.value(layout.first_child(index) + k);
    json.end_array();
  }
  write_place(json, f, layout.instance(index));
  if (options.physics != Physics::kNone) {
    json.key("extensions").begin_object();
    if (options.physics == Physics::kKhr)
      write_khr_physics_body(json, f, index, layout, options);
    else
      write_omi_physics_body(json, f, index, layout, options);
    json.end_object();
  }
  json.key("extras").begin_object().key("fracture");
  write_fragment_extras(json, fractured, index, options, sources);
  write_source_extras(json, *fractured.set.source, f.node);
  json.end_object().end_object();
}

void write_collider_nodes(JsonText& json, const Fragment& f, std::size_t fragment, const GltfOptions& options,
                          const SceneLayout& layout) {
  for (std::size_t hull = 0; hull < layout.collider_nodes(fragment); ++hull) {
    json.begin_object().member("name", layout.collider_name(fragment, hull));
    json.key("extensions").begin_object();
    if (options.physics == Physics::kKhr)
      write_khr_physics_collider(json, f, fragment, hull, layout, options);
    else
      write_omi_physics_collider(json, layout.hull_number(fragment, hull));
    json.end_object().end_object();
  }
}

/// Returns the position of the root's `extras.fracture` object in the text.
TextRange write_nodes(JsonText& json, const FracturedSolid& fractured, const GltfOptions& options,
                      const SceneLayout& layout, const std::vector<WholeNode>& whole,
                      const IntactScene& intact, const Execution& execution) {
  json.member("scene", 0).key("scenes").begin_array().begin_object();
  json.key("nodes").begin_array().value(0).end_array().end_object();
  if (!intact.is_empty()) {
    json.begin_object().member("name", "Intact").key("nodes").begin_array();
    json.value(intact.root()).end_array().end_object();
  }
  json.end_array().key("nodes").begin_array();
  const std::size_t fragments = fractured.set.fragments.size();
  const std::size_t first_cluster = layout.node_count() + whole.size() + intact.node_count();
  const ClusterNodes clusters(fractured, first_cluster, execution);
  const EmptyNodes empty(fractured.set, layout, whole, first_cluster + clusters.size(), execution);
  const SourceOfFragments sources(fractured.set, execution);
  const GroupNodes groups(fractured, sources, layout, whole, intact, empty, clusters.roots(),
                          empty.first_node() + empty.size(), execution);
  const TextRange figures = write_root(json, fractured, options, groups.of_root());
  for (std::size_t k = 0; k < fragments; ++k) write_fragment(json, fractured, k, options, layout, sources);
  for (std::size_t k = 0; k < fragments; ++k) {
    write_collider_nodes(json, fractured.set.fragments[k], k, options, layout);
    write_ucx_nodes(json, k, layout);
    if (layout.sheet_nodes(k) > 0)
      json.begin_object()
          .member("name", layout.sheet_name(k))
          .member("mesh", layout.sheet_mesh(k))
          .end_object();
  }
  for (std::size_t k = 0; k < whole.size(); ++k) {
    json.begin_object().member("name", whole[k].name).member("mesh", layout.mesh_count() + k);
    json.key("extras").begin_object().key("whole").begin_object().member("node", whole[k].node).end_object();
    if (!whole[k].extras.empty()) json.value_text(whole[k].extras);
    json.end_object().end_object();
  }
  intact.write_nodes(json, options);
  clusters.write(json, options);
  empty.write(json);
  groups.write(json);
  json.end_array();
  return figures;
}

/// Writes the source's materials, textures and samplers in their order. Materials of cuts and of the outside follow.
void write_materials(JsonText& json, const MaterialLibrary& library, const GltfOptions& options) {
  json.key("materials").begin_array();
  for (const auto& material : library.materials) json.value(material);
  for (const auto* list :
       {&options.interior.materials, &options.interior.cavities, &options.exterior.materials})
    for (const auto& material : *list) json.value(material);
  json.end_array();
  nlohmann::json textures = library.textures;
  if (options.interior.detail != CutDetail::kNone)
    for (std::size_t k = 0; k < 2; ++k) textures.push_back({{"source", library.images.size() + k}});
  if (!textures.empty()) json.member("textures", textures);
  if (!library.samplers.empty()) json.member("samplers", library.samplers);
}

void write_image(JsonText& json, const std::string& name, std::string_view type,
                 std::span<const std::uint8_t> bytes, std::size_t index, Accessors& accessors) {
  BufferContents& contents = accessors.contents();
  const std::size_t view = contents.view("image " + std::to_string(index), 0, 0);
  Pacer pacer(accessors.execution());
  for (const auto& piece : image_pieces(bytes, pacer))
    contents.put<write_bytes>(view, piece.size(), piece.front(), /*next=*/true);
  json.begin_object();
  if (!name.empty()) json.member("name", name);
  json.member("mimeType", type).member("bufferView", view).end_object();
}

void write_images(JsonText& json, const MaterialLibrary& library, CutDetail detail, Accessors& accessors) {
  if (library.images.empty() && detail == CutDetail::kNone) return;
  json.key("images").begin_array();
  std::size_t index = 0;
  for (const Image& image : library.images)
    write_image(json, image.name, image.mime_type, image.bytes, index++, accessors);
  if (detail != CutDetail::kNone) {
    const DetailMaps& maps = detail_maps(detail);
    write_image(json, "Interior_normal", "image/png", maps.normal, index++, accessors);
    write_image(json, "Interior_roughness", "image/png", maps.roughness, index, accessors);
  }
  json.end_array();
}

void write_meshes(JsonText& json, const FracturedSolid& fractured, const std::vector<MeshFigures>& figures,
                  const SceneLayout& layout, const std::vector<WholeNode>& whole, const IntactScene& intact,
                  const GltfOptions& options, MeshWriter& writer, const Execution& execution) {
  const FragmentSet& set = fractured.set;
  if (set.fragments.empty()) return;
  Pacer pacer(execution);
  json.key("meshes").begin_array();
  for (std::size_t k = 0; k < set.fragments.size(); ++k)
    if (layout.instance(k) == nullptr) writer.write(json, set.fragments[k], figures[k], layout.name(k));
  const InstancedBodies& instances = fractured.instances;
  for (const SceneLayout::Shape& shape : layout.shapes()) {
    const Fragment& mesh = instances.shapes[shape.index];
    writer.write(json, mesh, measure(mesh, options.mesh_manifold, pacer), layout.name(shape.fragment));
  }
  for (std::size_t k = 0; k < set.fragments.size(); ++k)
    for (std::size_t hull = 0; layout.instance(k) == nullptr && hull < layout.hulls(k); ++hull)
      writer.write(json, fractured.hulls.of(k)[hull], layout.hull_name(k, hull));
  for (const SceneLayout::Shape& shape : layout.shapes())
    for (std::size_t hull = 0; hull < layout.hulls(shape.fragment); ++hull)
      writer.write(json, instances.hulls[shape.index].hulls[hull], layout.hull_name(shape.fragment, hull));
  for (std::size_t k = 0; k < set.fragments.size(); ++k) {
    const std::shared_ptr<const Fragment>& sheet = set.fragments[k].sheet;
    if (sheet) writer.write(json, *sheet, measure(*sheet, false, pacer), layout.sheet_name(k));
  }
  for (const WholeNode& node : whole)
    writer.write_whole(json, node.mesh, measure(node.mesh, /*mesh_manifold=*/true, pacer), node.name);
  intact.write_meshes(json, options, writer);
  json.end_array();
}

/// Estimated length of the text. Rather too large, because a text that outgrows its memory is copied.
std::size_t expected_length(const FracturedSolid& fractured, const SceneLayout& layout) {
  const FragmentSet& set = fractured.set;
  std::size_t hulls = 0, sites = 0, bonds = set.bonds.size(), clusters = 0;
  for (std::size_t k = 0; k < set.fragments.size(); ++k) {
    hulls += layout.hulls(k);
    sites += set.fragments[k].sites.size();
  }
  for (const ClusterLevel& level : fractured.hierarchy.levels) {
    clusters += level.clusters.size();
    bonds += level.bonds.size();
  }
  const std::size_t groups = std::min(set.source->node_names.size(), set.fragments.size());
  return 4096 + 200 * groups + 2400 * set.fragments.size() + 600 * hulls + 8 * sites + 200 * bonds +
         800 * clusters;
}

/// Estimated number of accessors, rather too large.
std::size_t expected_accessors(const FragmentSet& set, const SceneLayout& layout) {
  std::size_t sum = 0;
  for (std::size_t k = 0; k < set.fragments.size(); ++k) {
    const Fragment& f = set.fragments[k];
    sum +=
        6 + f.attributes.uvs.size() + f.attributes.colors.size() + f.primitives.size() + 2 * layout.hulls(k);
  }
  return sum;
}

}  // namespace

GltfFile write_file(const FracturedSolid& fractured, const GltfOptions& options, OutputFormat format,
                    const Execution& execution) {
  const FragmentSet& set = fractured.set;
  const MaterialLibrary& library = *set.source->library;
  const std::vector<MeshFigures> figures = measure(set.fragments, options.mesh_manifold, execution);
  check_companions(fractured);
  const SceneLayout layout(fractured, options, execution);
  const std::vector<WholeNode> whole = whole_nodes(set, layout, execution);
  const IntactScene intact(fractured, options, layout, whole, execution);

  JsonText json(execution);
  json.reserve(expected_length(fractured, layout));
  json.begin_object();
  write_asset(json, set, options);
  write_extensions_used(json, set, options, layout);
  write_string_array(json, "extensionsRequired", library.extensions_required);
  write_document_extensions(json, set, options, layout, intact);
  TextRange root = write_nodes(json, fractured, options, layout, whole, intact, execution);
  write_materials(json, library, options);
  Accessors accessors(execution);
  accessors.expect(expected_accessors(set, layout));
  MeshWriter meshes(library, options.interior, options.exterior, options.mesh_manifold, accessors);
  write_meshes(json, fractured, figures, layout, whole, intact, options, meshes, execution);
  write_images(json, library, options.interior.detail, accessors);
  if (accessors.count() > 0) json.key("accessors").value_text(accessors.finish());
  const BufferContents& contents = accessors.contents();
  write_views(json, contents);
  const bool glb = format == OutputFormat::kGlb;
  if (glb) root.at += kGlbText;
  return {(glb ? pack_glb : pack_gltf)(std::move(json), contents, execution), root};
}

std::vector<std::uint8_t> write_glb(const FracturedSolid& fractured, const GltfOptions& options,
                                    const Execution& execution) {
  return write_file(fractured, options, OutputFormat::kGlb, execution).bytes;
}

std::vector<std::uint8_t> write_gltf(const FracturedSolid& fractured, const GltfOptions& options,
                                     const Execution& execution) {
  return write_file(fractured, options, OutputFormat::kGltf, execution).bytes;
}

}  // namespace fracture
