#include "common/fragment/components.hpp"

#include <algorithm>

#include "common/base/disjoint_sets.hpp"
#include "common/base/pacer.hpp"
#include "common/base/stamped_map.hpp"
#include "common/fragment/cavity_parents.hpp"

namespace fracture {
namespace {

/// Working memory that each thread reuses for all its owners.
struct ComponentScratch {
  DisjointSets sets;
  std::vector<std::uint32_t> component_of_root;

  std::size_t bytes() const { return sets.bytes() + bytes_of_vectors(component_of_root); }
  void release() {
    sets = DisjointSets();
    release_vectors(component_of_root);
  }
};

class ComponentFinder {
 public:
  ComponentFinder(const RestrictedDiagram& diagram, const Ownership& ownership, const Execution& execution)
      : d_(diagram), ownership_(ownership), execution_(execution), pacer_(execution) {}

  std::vector<Component> find(const OwnerShare& share) {
    local_.next_epoch(d_.vertex_count());
    sets_.clear();
    std::size_t count = share.surface.size();
    for (const FaceSource source : share.caps) count += d_.caps.regions[cap_region(source)].triangle_count;
    // The surface's triangles were counted when it was divided.
    execution_.made(Product::kFragmentTriangles, count - share.surface.size());
    faces_.clear();
    faces_.reserve(count);
    sets_.reserve(count / 2 + 8);  // a closed surface has about half as many vertices as faces
    faces_.assign(share.surface.begin(), share.surface.end());
    pacer_.each(0, faces_.size(), [&](std::size_t k) { join(faces_[k].v); });
    for (const FaceSource source : share.caps) {
      const CapRegion& r = d_.caps.regions[cap_region(source)];
      const bool inner = ownership_.owner_of_site[r.lo] == ownership_.owner_of_site[r.hi];
      pacer_.each(r.first_triangle, r.first_triangle + r.triangle_count, [&](std::size_t k) {
        const auto& v = d_.caps.triangles[k];
        join(v);
        if (!inner)
          faces_.push_back(cap_side(source) == 0 ? Face{v, source} : Face{{v[0], v[2], v[1]}, source});
      });
    }
    // Within a group, fused faces skip vertices, so the cells' own polygons decide what is connected.
    for (const std::uint32_t p : share.polygons) {
      const CutPolygon& polygon = d_.cuts.polygons[p];
      pacer_.step(polygon.count);
      for (std::uint32_t k = 2; k < polygon.count; ++k)
        join({d_.cuts.vertices[polygon.first], d_.cuts.vertices[polygon.first + k - 1],
              d_.cuts.vertices[polygon.first + k]});
    }
    std::vector<Component> components = collect();
    if (ownership_.sites_of_owner[share.owner].size() > 1) collect_bodies(share, components);
    return components;
  }

 private:
  void join(const std::array<CutVertexId, 3>& v) {
    std::uint32_t id[3];
    for (int k = 0; k < 3; ++k) {
      std::uint32_t& slot = local_.slot(v[k]);
      if (slot == kNoIndex) slot = sets_.add();
      id[k] = slot;
    }
    sets_.unite(id[0], id[1]);
    sets_.unite(id[1], id[2]);
  }

  std::vector<Component> collect() {
    std::vector<Component> components;
    if (faces_.empty()) return components;
    // Usually there is one component, so nothing has to be sorted or measured.
    if (sets_.set_count() == 1) {
      Component& only = components.emplace_back();
      only.part = part_of(faces_[0]);
      only.faces = std::move(faces_);
      faces_ = {};
      return components;
    }
    component_of_root_.clear();
    for (const Face& f : faces_) {
      pacer_.step();
      const std::uint32_t root = sets_.find(local_.slot(f.v[0]));
      if (component_of_root_.size() <= root) component_of_root_.resize(root + 1, kNoIndex);
      std::uint32_t& c = component_of_root_[root];
      if (c == kNoIndex) {
        c = static_cast<std::uint32_t>(components.size());
        components.emplace_back();
        components.back().part = part_of(f);
      }
      components[c].faces.push_back(f);
      components[c].has_caps |= is_cap(f.source);
    }
    for (Component& c : components) {
      pacer_.step(c.faces.size());
      c.volume = signed_volume(d_, c.faces.data(), c.faces.size(), d_.point(c.faces[0].v[0]));
    }
    give_cavities_to_parents(d_, components, pacer_);
    std::stable_sort(components.begin(), components.end(),
                     [](const Component& a, const Component& b) { return a.part < b.part; });
    return components;
  }

  // Collects the vertices of every cell's faces in a group, by the component to which they belong.
  void collect_bodies(const OwnerShare& share, std::vector<Component>& components) {
    struct Share {
      std::uint32_t component;
      SiteId cell;
      CutVertexId vertex;
      auto operator<=>(const Share&) const = default;
    };
    std::vector<std::uint32_t> component_of(sets_.size(),
                                            kNoIndex);  // per root, because components were reordered
    for (std::uint32_t c = 0; c < components.size(); ++c)
      for (const Face& f : components[c].faces) component_of[sets_.find(local_.slot(f.v[0]))] = c;
    std::vector<Share> shares;
    // Most vertices of a cell belong to several of its faces. For the first 64 cells, each vertex is added
    // only once.
    const std::vector<SiteId>& cells = ownership_.sites_of_owner[share.owner];
    std::vector<std::uint64_t> noted(sets_.size(), 0);  // per vertex: a bit for each of these cells
    const auto number_of = [&](SiteId cell) {
      return static_cast<std::size_t>(std::lower_bound(cells.begin(), cells.end(), cell) - cells.begin());
    };
    const auto add = [&](SiteId cell, std::size_t number, CutVertexId v) {
      pacer_.step();
      const std::uint32_t local = local_.slot(v);
      if (number < 64) {
        const std::uint64_t bit = std::uint64_t{1} << number;
        if (noted[local] & bit) return;
        noted[local] |= bit;
      }
      const std::uint32_t c = component_of[sets_.find(local)];
      if (c != kNoIndex) shares.push_back({c, cell, v});
    };
    for (const Component& c : components)
      for (const Face& f : c.faces)
        if (!is_cap(f.source))
          for (const CutVertexId v : f.v)
            if (v < d_.cuts.first_b()) add(d_.cuts.label[v], number_of(d_.cuts.label[v]), v);
    for (const FaceSource source : share.caps) {
      const CapRegion& r = d_.caps.regions[cap_region(source)];
      for (const SiteId cell : {r.lo, r.hi}) {
        if (ownership_.owner_of_site[cell] != share.owner) continue;
        const std::size_t number = number_of(cell);
        for (std::uint32_t k = 0; k < r.triangle_count; ++k)
          for (const CutVertexId v : d_.caps.triangles[r.first_triangle + k]) add(cell, number, v);
      }
    }
    for (const std::uint32_t p : share.polygons) {
      const CutPolygon& polygon = d_.cuts.polygons[p];
      const std::size_t number = number_of(polygon.cell);
      for (std::uint32_t k = 0; k < polygon.count; ++k)
        add(polygon.cell, number, d_.cuts.vertices[polygon.first + k]);
    }
    sort_with_polls(execution_, shares.begin(), shares.end());
    shares.erase(std::unique(shares.begin(), shares.end()), shares.end());
    for (std::size_t k = 0; k < shares.size(); ++k) {
      if (k == 0 || shares[k].component != shares[k - 1].component || shares[k].cell != shares[k - 1].cell)
        components[shares[k].component].bodies.emplace_back();
      components[shares[k].component].bodies.back().push_back(shares[k].vertex);
    }
  }

  std::uint32_t part_of(const Face& f) const {
    return is_cap(f.source) ? d_.caps.regions[cap_region(f.source)].part : d_.solid.part[f.source];
  }

  const RestrictedDiagram& d_;
  const Ownership& ownership_;
  const Execution& execution_;
  Pacer pacer_;
  StampedMap& local_ = worker_map();
  ComponentScratch& scratch_ = thread_scratch<ComponentScratch>();
  DisjointSets& sets_ = scratch_.sets;
  std::vector<std::uint32_t>& component_of_root_ = scratch_.component_of_root;
  std::vector<Face> faces_;
};

}  // namespace

std::vector<Component> find_components(const RestrictedDiagram& diagram, const Ownership& ownership,
                                       const OwnerShare& share, const Execution& execution) {
  return ComponentFinder(diagram, ownership, execution).find(share);
}

}  // namespace fracture
