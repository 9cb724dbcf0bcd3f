#include "common/mesh/proxies.hpp"

#include <algorithm>
#include <charconv>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/base/printable.hpp"
#include "common/base/words.hpp"
#include "common/mesh/selection.hpp"

namespace fracture {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + ('a' - 'A'));
  return result;
}

/// Returns the name without the digits at its end and the character before them, if that is in `separators`.
std::string_view without_number(std::string_view name, std::string_view separators,
                                std::size_t least_digits) {
  std::size_t begin = name.size();
  while (begin > 0 && is_digit(name[begin - 1])) --begin;
  const bool numbered = name.size() - begin >= least_digits && begin > 1 &&
                        separators.find(name[begin - 1]) != std::string_view::npos;
  return numbered ? name.substr(0, begin - 1) : name;
}

/// "Crate_LOD2": "Crate" and 2. Blender's number of a copy (".001") becomes part of the stem.
struct Level {
  std::string stem;
  unsigned level;
};
std::optional<Level> level_in(std::string_view name) {
  const std::string_view text = without_number(name, ".", 3), copy = name.substr(text.size());
  std::size_t begin = text.size();
  while (begin > 0 && is_digit(text[begin - 1])) --begin;
  constexpr std::string_view kMark = "_lod";
  const std::size_t digits = text.size() - begin;
  if (digits < 1 || digits > 2 || begin <= kMark.size() ||
      lower(text.substr(begin - kMark.size(), kMark.size())) != kMark)
    return std::nullopt;
  Level result{std::string(text.substr(0, begin - kMark.size())) + std::string(copy), 0};
  std::from_chars(text.data() + begin, text.data() + text.size(), result.level);
  return result;
}

/// The meaning of a name of collision geometry.
struct HullName {
  std::vector<std::string> owners;  ///< possible names of the owner, the likeliest first
  bool convex;
  bool hidden;  ///< never visible, even without an owner
};
std::optional<HullName> hull_in(std::string_view name) {
  for (const std::string_view prefix : {"UCX_", "UBX_", "USP_", "UCP_"}) {
    if (!name.starts_with(prefix) || name.size() == prefix.size()) continue;
    HullName hull{{}, true, false};
    constexpr std::size_t kMostNumbers = 3;
    std::string_view owner = name.substr(prefix.size());
    while (hull.owners.size() <= kMostNumbers && (hull.owners.empty() || owner != hull.owners.back())) {
      hull.owners.emplace_back(owner);
      owner = without_number(owner, "_.", 1);
    }
    return hull;
  }
  // Godot ignores a number at the end. It also accepts $ and _ instead of -, but "Temple_col" may be a column.
  const std::size_t end = name.find_last_not_of("0123456789 _.");
  const std::string_view text = name.substr(0, end == std::string_view::npos ? 0 : end + 1);
  for (const std::string_view suffix : {"-col", "-colonly", "-convcol", "-convcolonly", "$col", "$colonly",
                                        "$convcol", "$convcolonly", "_colonly", "_convcol", "_convcolonly"}) {
    if (text.size() <= suffix.size() || lower(text.substr(text.size() - suffix.size())) != suffix) continue;
    const std::string owner(text.substr(0, text.size() - suffix.size()));
    return HullName{{owner + std::string(name.substr(text.size())), owner},
                    suffix.substr(1).starts_with("conv"),
                    suffix.ends_with("only")};
  }
  return std::nullopt;
}

enum class Role : char {
  kMesh,
  kLevel,       // of detail
  kHull,        // of a node that is broken
  kUnusedHull,  // of a level of detail that is left out
  kHidden,      // collision geometry without an owner
};

using Owners = std::shared_ptr<const std::vector<std::uint32_t>>;

/// Finds the role of each node.
class Cast {
 public:
  Cast(const Mesh& mesh, Pacer& pacer)
      : mesh_(mesh),
        pacer_(pacer),
        count_(mesh.node_names.size()),
        role_(count_, Role::kMesh),
        owners_(count_) {
    find_nodes();
    find_levels();
    find_hulls();
  }

  Role role(std::uint32_t node) const { return node < count_ ? role_[node] : Role::kMesh; }
  const Owners& owners(std::uint32_t node) const { return owners_[node]; }
  bool is_convex(std::uint32_t node) const { return hull_[node]->convex; }
  bool has_proxies() const {
    return std::any_of(role_.begin(), role_.end(), [](Role role) { return role != Role::kMesh; });
  }

 private:
  void find_nodes() {
    is_broken_.resize(count_);
    const auto mark = [&](std::vector<bool>& marks, const std::vector<std::uint32_t>& nodes) {
      pacer_.each(0, nodes.size(), [&](std::size_t t) {
        if (nodes[t] < count_) marks[nodes[t]] = true;
      });
    };
    mark(is_broken_, mesh_.node);
    is_there_ = is_broken_;
    if (mesh_.passed_through) mark(is_there_, mesh_.passed_through->node);
    hull_.resize(count_);
    for (std::uint32_t k = 0; k < count_; ++k) {
      pacer_.step(kName);
      if (is_there_[k]) hull_[k] = hull_in(mesh_.node_names[k]);
    }
  }

  void find_levels() {
    std::set<std::string> stems;  // of nodes that are broken and have level 0
    std::vector<std::optional<Level>> level(count_);
    for (std::uint32_t k = 0; k < count_; ++k) {
      pacer_.step(kName);
      if (!is_there_[k] || hull_[k]) continue;
      level[k] = level_in(mesh_.node_names[k]);
      if (level[k] && level[k]->level == 0 && is_broken_[k]) stems.insert(level[k]->stem);
    }
    for (std::uint32_t k = 0; k < count_; ++k)
      if (level[k] && level[k]->level > 0 && stems.contains(level[k]->stem)) role_[k] = Role::kLevel;
  }

  /// Adds the node to the owners that a name may mean, if some collision geometry wants an owner of this name.
  void name_owner(std::uint32_t node, const std::string& name) {
    const auto add = [&](const std::string& wanted) {
      const auto at = named_.find(wanted);
      if (at != named_.end() && (at->second.empty() || at->second.back() != node)) at->second.push_back(node);
    };
    add(name);
    if (const auto level = level_in(name); level && level->level == 0) add(level->stem);
  }

  /// For each name of an owner: the nodes of this name, or below a node of this name.
  void find_owners() {
    const std::vector<NodeGroup>& groups = mesh_.groups;
    std::vector<std::uint32_t> wanted(groups.size(), kNoIndex);  // the innermost group, from this one on
    for (std::uint32_t g = 0; g < groups.size(); ++g) {
      pacer_.step(kName);
      const auto level = level_in(groups[g].name);
      if (named_.contains(groups[g].name) || (level && level->level == 0 && named_.contains(level->stem)))
        wanted[g] = g;
      else if (groups[g].parent != kNoIndex)
        wanted[g] = wanted[groups[g].parent];
    }
    for (std::uint32_t k = 0; k < count_; ++k) {
      pacer_.step(kName);
      if (!is_broken_[k] || hull_[k]) continue;
      name_owner(k, mesh_.node_names[k]);
      constexpr int kMostGroups = 64;  // so that deep scenes cost linear time
      std::uint32_t group = k < mesh_.group_of_node.size() ? mesh_.group_of_node[k] : kNoIndex;
      for (int n = 0; n < kMostGroups && group != kNoIndex && wanted[group] != kNoIndex; ++n) {
        pacer_.step(kName);
        name_owner(k, groups[wanted[group]].name);
        group = groups[wanted[group]].parent;
      }
    }
  }

  void find_hulls() {
    for (const auto& hull : hull_)
      if (hull)
        for (const std::string& owner : hull->owners) named_.try_emplace(owner);
    if (named_.empty()) return;
    find_owners();
    std::map<std::string, Owners> kept;  // without levels of detail
    for (const auto& [name, nodes] : named_) {
      std::vector<std::uint32_t> left;
      pacer_.step(kName + nodes.size());
      for (const std::uint32_t node : nodes)
        if (role_[node] == Role::kMesh) left.push_back(node);
      kept[name] = std::make_shared<const std::vector<std::uint32_t>>(std::move(left));
    }
    for (std::uint32_t k = 0; k < count_; ++k) {
      if (!hull_[k]) continue;
      if (hull_[k]->hidden && is_broken_[k]) role_[k] = Role::kHidden;
      for (const std::string& owner : hull_[k]->owners) {
        pacer_.step(kName);
        if (named_[owner].empty()) continue;
        owners_[k] = kept[owner];
        role_[k] = owners_[k]->empty() ? Role::kUnusedHull : Role::kHull;
        break;
      }
    }
    bool any_mesh = false;
    for (std::uint32_t k = 0; k < count_; ++k)
      any_mesh = any_mesh || (is_broken_[k] && role_[k] == Role::kMesh);
    if (!any_mesh) std::replace(role_.begin(), role_.end(), Role::kHidden, Role::kMesh);
  }

  static constexpr std::uint64_t kName = 16;  // steps for the work on one name

  const Mesh& mesh_;
  Pacer& pacer_;
  const std::size_t count_;
  std::vector<bool> is_broken_, is_there_;  ///< have triangles in the mesh; or there or in passed_through
  std::vector<std::optional<HullName>> hull_;
  std::map<std::string, std::vector<std::uint32_t>> named_;
  std::vector<Role> role_;
  std::vector<Owners> owners_;
};

/// Collects the triangles of collision geometry.
class HullTaker {
 public:
  HullTaker(const Mesh& mesh, const Cast& cast) : cast_(cast), number_(mesh.node_names.size(), kNoIndex) {
    for (std::uint32_t k = 0; k < number_.size(); ++k) {
      if (cast.role(k) != Role::kHull) continue;
      number_[k] = static_cast<std::uint32_t>(hulls_.size());
      hulls_.push_back({mesh.node_names[k], cast.owners(k), cast.is_convex(k), {}, {}});
    }
    known_.resize(hulls_.size());
  }

  void take(const Mesh& mesh, Pacer& pacer) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      pacer.step();
      const std::uint32_t node = mesh.node[t];
      if (cast_.role(node) != Role::kHull) continue;
      pacer.step(32);
      std::array<std::uint32_t, 3> corners{};
      for (std::size_t k = 0; k < 3; ++k)
        corners[k] = point(number_[node], mesh.positions[mesh.triangles[t][k]]);
      if (corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0])
        hulls_[number_[node]].triangles.push_back(corners);
    }
  }

  std::vector<GivenHull> hulls() && { return std::move(hulls_); }

 private:
  std::uint32_t point(std::uint32_t hull, const Vec3f& p) {
    std::vector<Vec3f>& points = hulls_[hull].points;
    const auto [at, is_new] =
        known_[hull].try_emplace({p.x, p.y, p.z}, static_cast<std::uint32_t>(points.size()));
    if (is_new) points.push_back(p);
    return at->second;
  }

  const Cast& cast_;
  std::vector<std::uint32_t> number_;  ///< per node
  std::vector<GivenHull> hulls_;
  std::vector<std::map<std::array<float, 3>, std::uint32_t>> known_;  ///< per hull
};

/// Removes all proxies from the mesh.
void keep_meshes(Mesh& mesh, const Cast& cast, Pacer& pacer) {
  std::vector<bool> kept(mesh.triangles.size());
  pacer.each(0, kept.size(), [&](std::size_t t) { kept[t] = cast.role(mesh.node[t]) == Role::kMesh; });
  keep_triangles(mesh, kept, pacer);
}

/// Names of nodes in a sentence.
class NameList {
 public:
  void add(const std::string& name) {
    if (!known_.insert(name).second) return;
    constexpr std::size_t kMostNamed = 5;
    if (known_.size() <= kMostNamed)
      text_ += (text_.empty() ? "" : ", ") + printable(shortened(name));
    else
      ++further_;
  }
  /// Returns "2 nodes are", and below "A, B".
  std::string count() const { return counted(known_.size(), "node is", "nodes are"); }
  std::string names() const {
    return text_ + (further_ > 0 ? " and " + grouped(further_) + " more" : std::string());
  }
  bool empty() const { return known_.empty(); }

 private:
  std::set<std::string> known_;
  std::string text_;
  std::size_t further_ = 0;
};

void report(Mesh& mesh, const Cast& cast) {
  NameList hulls, hidden;
  const char* const kGeometry = "collision geometry";
  for (std::uint32_t k = 0; k < mesh.node_names.size(); ++k) {
    const std::string& name = mesh.node_names[k];
    switch (cast.role(k)) {
      case Role::kMesh:
        continue;
      case Role::kLevel:
        mesh.dropped.push_back(
            {"level of detail", name, "only level 0 is broken; to break all levels, use proxies=geometry"});
        break;
      case Role::kHull:
        hulls.add(name);
        mesh.dropped.push_back({kGeometry, name, "only the unbroken mesh has it (intact=true)"});
        break;
      case Role::kUnusedHull:
        mesh.dropped.push_back(
            {kGeometry, name,
             "its level of detail is left out; to break it like other nodes, use proxies=geometry"});
        break;
      case Role::kHidden:
        hidden.add(name);
        mesh.dropped.push_back({kGeometry, name, "it is never visible, and its name matches no mesh"});
        break;
    }
  }
  if (!hulls.empty())
    mesh.remarks.warn(
        hulls.count() + " named as collision geometry and therefore not broken: " + hulls.names() +
        ". With intact=true, the unbroken mesh uses this geometry as colliders. To break it like other "
        "nodes, use proxies=geometry.");
  if (!hidden.empty())
    mesh.remarks.warn(hidden.count() +
                      " named as collision geometry, which is never visible, and therefore left out: " +
                      hidden.names() + ". To break this geometry like other nodes, use proxies=geometry.");
  shorten_dropped(mesh.dropped);
}

}  // namespace

void take_proxies(Mesh& mesh, const Execution& execution) {
  const bool has_nodes =
      mesh.node.size() == mesh.triangles.size() &&
      (!mesh.passed_through || mesh.passed_through->node.size() == mesh.passed_through->triangles.size());
  if (!has_nodes) return;
  Pacer pacer(execution);
  const Cast cast(mesh, pacer);
  if (!cast.has_proxies()) return;
  HullTaker taker(mesh, cast);
  taker.take(mesh, pacer);
  if (mesh.passed_through) {
    taker.take(*mesh.passed_through, pacer);
    auto rest = std::make_shared<Mesh>(*mesh.passed_through);
    keep_meshes(*rest, cast, pacer);
    mesh.passed_through = rest->triangles.empty() ? nullptr : std::move(rest);
  }
  report(mesh, cast);
  keep_meshes(mesh, cast, pacer);
  mesh.given_hulls = std::move(taker).hulls();
  std::erase_if(mesh.given_hulls, [](const GivenHull& hull) { return hull.triangles.empty(); });
}

}  // namespace fracture
