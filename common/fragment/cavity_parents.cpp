#include "common/fragment/cavity_parents.hpp"

#include <algorithm>
#include <memory>
#include <numeric>

#include "common/bvh/ray_crossing.hpp"
#include "common/solid/stabbing_tree.hpp"

namespace fracture {
namespace {

using solid_detail::Slabs;
using solid_detail::StabbingTree;

/// Coordinates along the axes and along the diagonals of their planes. The diagonals also separate long
/// pieces that lie obliquely.
constexpr int kDirections = 9;
std::array<double, kDirections> along_directions(const Vec3d& p) {
  return {p.x, p.y, p.z, p.x + p.y, p.x - p.y, p.y + p.z, p.y - p.z, p.z + p.x, p.z - p.x};
}

/// The components of one part that have a positive volume.
class Surroundings {
 public:
  Surroundings(const RestrictedDiagram& diagram, const std::vector<Component>& components,
               std::vector<std::uint32_t> members, Pacer& pacer)
      : d_(diagram), components_(components), members_(std::move(members)), pacer_(pacer) {}

  /// Returns the component that takes a cavity with the vertex q, or kNoIndex.
  std::uint32_t parent_of(const Vec3d& q) {
    // A component that took cavities larger than itself has no volume left.
    std::erase_if(members_, [&](std::uint32_t p) { return components_[p].volume <= 0; });
    if (members_.empty()) return kNoIndex;
    if (members_.size() == 1) return members_[0];
    if (!tree_) build();
    std::uint32_t parent = kNoIndex;
    tree_->for_each_near(along_directions(q), [&](std::uint32_t p) {
      const Component& piece = components_[p];
      if (piece.volume <= 0 || !contains(slabs_[p], along_directions(q)) || winding_of(p, q) == 0) return;
      if (parent == kNoIndex || piece.volume < components_[parent].volume ||
          (piece.volume == components_[parent].volume && p < parent))
        parent = p;
    });
    return parent;
  }

 private:
  template <std::size_t K>
  static bool contains(const std::array<std::array<double, 2>, K>& slabs, const std::array<double, K>& q) {
    for (std::size_t k = 0; k < K; ++k)
      if (q[k] < slabs[k][0] || q[k] > slabs[k][1]) return false;
    return true;
  }

  void build() {
    slabs_.resize(components_.size());
    own_.resize(components_.size());
    for (const std::uint32_t p : members_) {
      own_[p].faces = static_cast<std::uint32_t>(components_[p].faces.size());
      slabs_[p].fill({HUGE_VAL, -HUGE_VAL});
      for (const Face& f : components_[p].faces) {
        pacer_.step();
        for (const CutVertexId v : f.v) {
          const std::array<double, kDirections> at = along_directions(d_.point(v));
          for (int k = 0; k < kDirections; ++k) {
            slabs_[p][k][0] = std::min(slabs_[p][k][0], at[k]);
            slabs_[p][k][1] = std::max(slabs_[p][k][1], at[k]);
          }
        }
      }
    }
    tree_ = std::make_unique<StabbingTree<kDirections>>(
        members_, [&](std::uint32_t p) { return slabs_[p]; }, pacer_);
  }

  /// Winding number of component p around q, from the faces that the ray from q towards +x may meet. Faces
  /// of cavities that p has taken do not count.
  int winding_of(std::uint32_t p, const Vec3d& q) {
    const std::vector<Face>& faces = components_[p].faces;
    int winding = 0;
    const auto add = [&](std::uint32_t f) {
      const auto& v = faces[f].v;
      winding += ray_crossing(d_.point(v[0]) - q, d_.point(v[1]) - q, d_.point(v[2]) - q);
      pacer_.step();
    };
    Own& own = own_[p];
    if (!own.tree && own.faces > kFew) {
      std::vector<std::uint32_t> all(own.faces);
      std::iota(all.begin(), all.end(), 0u);
      own.tree = std::make_unique<StabbingTree<2>>(
          std::move(all), [&](std::uint32_t f) { return across(faces[f]); }, pacer_);
    }
    if (own.tree)
      own.tree->for_each_near({q.y, q.z}, add);
    else
      for (std::uint32_t f = 0; f < own.faces; ++f) add(f);
    return winding;
  }
  Slabs<2> across(const Face& f) const {
    Slabs<2> slabs;
    slabs.fill({HUGE_VAL, -HUGE_VAL});
    for (const CutVertexId v : f.v) {
      const Vec3d p = d_.point(v);
      slabs[0] = {std::min(slabs[0][0], p.y), std::max(slabs[0][1], p.y)};
      slabs[1] = {std::min(slabs[1][0], p.z), std::max(slabs[1][1], p.z)};
    }
    return slabs;
  }

  static constexpr std::uint32_t kFew = 64;  // up to this number, faces are tested one by one
  /// A component before it took cavities.
  struct Own {
    std::uint32_t faces = 0;
    std::unique_ptr<StabbingTree<2>> tree{};  // of its faces; built on first use
  };
  const RestrictedDiagram& d_;
  const std::vector<Component>& components_;
  std::vector<std::uint32_t> members_;
  Pacer& pacer_;
  std::vector<Slabs<kDirections>> slabs_;  // per component
  std::unique_ptr<StabbingTree<kDirections>> tree_;
  std::vector<Own> own_;  // per component
};

}  // namespace

void give_cavities_to_parents(const RestrictedDiagram& d, std::vector<Component>& components, Pacer& pacer) {
  const auto is_cavity = [](const Component& c) { return !c.has_caps && !(c.volume > 0); };
  if (std::none_of(components.begin(), components.end(), is_cavity)) return;
  std::vector<std::uint32_t> order(components.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    pacer.step();
    return components[a].part < components[b].part;
  });
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    std::vector<std::uint32_t> members, cavities;
    for (; end < order.size() && components[order[end]].part == components[order[begin]].part; ++end) {
      const Component& c = components[order[end]];
      if (is_cavity(c))
        cavities.push_back(order[end]);
      else if (c.volume > 0)
        members.push_back(order[end]);
    }
    Surroundings pieces(d, components, std::move(members), pacer);
    for (const std::uint32_t c : cavities) {
      Component& cavity = components[c];
      const std::uint32_t parent = pieces.parent_of(d.point(cavity.faces[0].v[0]));
      if (parent == kNoIndex) continue;
      Component& to = components[parent];
      to.faces.insert(to.faces.end(), cavity.faces.begin(), cavity.faces.end());
      to.volume += cavity.volume;
      pacer.step(cavity.faces.size());
      cavity.faces.clear();
    }
  }
  std::erase_if(components, [](const Component& c) { return c.faces.empty(); });
}

}  // namespace fracture
