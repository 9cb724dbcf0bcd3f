#include "common/hollow/rebuild.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/hollow/extended_source.hpp"
#include "common/hollow/inner_surface.hpp"

namespace fracture::hollow_detail {
namespace {

class Rebuilder {
 public:
  Rebuilder(Solid& solid, const std::vector<Cavity>& cavities, const Execution& execution)
      : solid_(solid),
        cavities_(cavities),
        pacer_(execution),
        corners_(sum(&InnerSurface::positions)),
        added_(sum(&InnerSurface::triangles)),
        source_(*solid.source, corners_, added_, execution) {}

  void run() {
    const std::vector<Run> runs = runs_of_parts(solid_);
    reserve();
    auto next = cavities_.begin();
    for (std::size_t p = 0; p < solid_.parts.size(); ++p) {
      for (std::size_t t = runs[p].begin; t < runs[p].end; ++t) copy(t);
      if (next != cavities_.end() && next->part == p) add(*next++);
    }
    solid_.triangles = std::move(triangles_);
    solid_.wedges = std::move(wedges_);
    solid_.material = std::move(material_);
    solid_.edges = std::move(edges_);
    solid_.shell = std::move(shell_);
    solid_.part = std::move(part_);
    solid_.source = std::move(source_).finished();
  }

 private:
  template <class List>
  std::size_t sum(List InnerSurface::*list) const {
    std::size_t count = 0;
    for (const Cavity& cavity : cavities_) count += (cavity.surface.*list).size();
    return count;
  }

  void reserve() {
    const std::size_t count = solid_.triangles.size() + added_;
    triangles_.reserve(count);
    wedges_.reserve(count);
    material_.reserve(count);
    edges_.reserve(count);
    shell_.reserve(count);
    part_.reserve(count);
    solid_.positions.reserve(solid_.positions.size() + corners_);
  }

  void copy(std::size_t t) {
    pacer_.step();
    triangles_.push_back(solid_.triangles[t]);
    wedges_.push_back(solid_.wedges[t]);
    material_.push_back(solid_.material[t]);
    edges_.push_back(solid_.edges[t]);
    shell_.push_back(solid_.shell[t]);
    part_.push_back(solid_.part[t]);
  }

  void add(const Cavity& cavity) {
    const auto first_vertex = static_cast<std::uint32_t>(solid_.positions.size());
    Part& part = solid_.parts[cavity.part];
    const std::uint32_t first_wedge = source_.add_wedges(cavity.surface);
    solid_.positions.insert(solid_.positions.end(), cavity.surface.positions.begin(),
                            cavity.surface.positions.end());
    const auto first_shell = static_cast<std::uint32_t>(solid_.report.shells);
    for (std::uint32_t s = 0; s < cavity.shells; ++s) part.shells.push_back(first_shell + s);
    solid_.report.shells += cavity.shells;
    solid_.report.cavities += cavity.shells;
    std::map<std::array<std::uint32_t, 2>, std::uint32_t> edge_of;
    for (std::size_t t = 0; t < cavity.surface.triangles.size(); ++t) {
      pacer_.step(16);
      const auto& corner = cavity.surface.triangles[t];
      std::array<VertexId, 3>& triangle = triangles_.emplace_back();
      std::array<std::uint32_t, 3>&wedges = wedges_.emplace_back(), &edges = edges_.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) {
        triangle[k] = VertexId{first_vertex + corner[k]};
        wedges[k] = first_wedge + corner[k];
        const auto [low, high] = std::minmax(corner[k], corner[(k + 1) % 3]);
        const auto [edge, is_new] =
            edge_of.try_emplace({low, high}, static_cast<std::uint32_t>(solid_.edge_vertices.size()));
        if (is_new)
          solid_.edge_vertices.push_back({VertexId{first_vertex + low}, VertexId{first_vertex + high}});
        edges[k] = edge->second;
      }
      material_.push_back(kCavityMaterial);
      shell_.push_back(first_shell + cavity.shell_of_triangle[t]);
      part_.push_back(static_cast<std::uint32_t>(cavity.part));
      source_.add_triangle(wedges, part);
    }
  }

  Solid& solid_;
  const std::vector<Cavity>& cavities_;
  Pacer pacer_;
  std::size_t corners_, added_;
  ExtendedSource source_;
  std::vector<std::array<VertexId, 3>> triangles_;
  std::vector<std::array<std::uint32_t, 3>> wedges_, edges_;
  std::vector<std::uint32_t> material_, shell_, part_;
};

}  // namespace

std::vector<Run> runs_of_parts(const Solid& solid) {
  std::vector<Run> runs(solid.parts.size());
  for (std::size_t t = 0; t < solid.part.size(); ++t) {
    Run& run = runs[solid.part[t]];
    if (run.end == 0) run.begin = t;
    run.end = t + 1;
  }
  return runs;
}

void rebuild(Solid& solid, const std::vector<Cavity>& cavities, const Execution& execution) {
  Rebuilder(solid, cavities, execution).run();
}

}  // namespace fracture::hollow_detail
