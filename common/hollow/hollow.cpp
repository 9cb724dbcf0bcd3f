#include "common/hollow/hollow.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "common/base/disjoint_sets.hpp"
#include "common/base/pacer.hpp"
#include "common/hollow/inner_surface.hpp"
#include "common/hollow/triangle_tree.hpp"

namespace fracture {
namespace {

using hollow_detail::Corners;
using hollow_detail::InnerSurface;
using hollow_detail::TriangleTree;

/// The triangles of a part: they follow one another.
struct Run {
  std::size_t begin = 0, end = 0;
};

std::vector<Run> runs_of_parts(const Solid& solid) {
  std::vector<Run> runs(solid.parts.size());
  for (std::size_t t = 0; t < solid.part.size(); ++t) {
    Run& run = runs[solid.part[t]];
    if (run.end == 0) run.begin = t;
    run.end = t + 1;
  }
  return runs;
}

TriangleTree tree_of(const Solid& solid, const Run& run, const Execution& execution) {
  Pacer pacer(execution);
  std::vector<Corners> triangles;
  triangles.reserve(run.end - run.begin);
  for (std::size_t t = run.begin; t < run.end; ++t) {
    pacer.step(4);
    Corners& corners = triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) corners[k] = to_double(solid.positions[solid.triangles[t][k]]);
  }
  return TriangleTree(std::move(triangles), execution);
}

/// A surface of one part, divided into the shells that hang together.
struct Cavity {
  std::size_t part;
  InnerSurface surface;
  std::vector<std::uint32_t> shell_of_triangle;
  std::uint32_t shells = 0;
};

std::vector<std::uint32_t> shells_of(const InnerSurface& surface, std::uint32_t& count) {
  DisjointSets sets;
  sets.reserve(surface.positions.size());
  for (std::size_t v = 0; v < surface.positions.size(); ++v) sets.add();
  for (const auto& [a, b, c] : surface.triangles) {
    sets.unite(a, b);
    sets.unite(a, c);
  }
  std::vector<std::uint32_t> number(surface.positions.size(), kNoIndex), shells;
  shells.reserve(surface.triangles.size());
  for (const auto& triangle : surface.triangles) {
    std::uint32_t& n = number[sets.find(triangle[0])];
    if (n == kNoIndex) n = count++;
    shells.push_back(n);
  }
  return shells;
}

Corners corners_of(const InnerSurface& surface, std::size_t t) {
  Corners corners;
  for (std::size_t k = 0; k < 3; ++k) corners[k] = to_double(surface.positions[surface.triangles[t][k]]);
  return corners;
}

/// The middle of a part's box is the origin of volumes, so that little is lost to rounding.
double volume_of(const InnerSurface& surface, const Vec3d& origin) {
  double six = 0;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto [a, b, c] = corners_of(surface, t);
    six -= dot(a - origin, cross(b - origin, c - origin));
  }
  return six / 6;
}

/// Adds what the walls of a part measure; sums of thickness times area, which the caller divides.
void measure(const InnerSurface& surface, const TriangleTree& tree, SolidReport& report, double& area,
             Pacer& pacer) {
  double least = report.parts_hollowed == 0 ? HUGE_VAL : report.least_thickness;
  for (const Vec3f& p : surface.positions) {
    pacer.step(16);
    least = std::fmin(least, tree.distance(to_double(p)));
  }
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    pacer.step(16);
    const auto [a, b, c] = corners_of(surface, t);
    const double size = length(cross(b - a, c - a)) / 2;
    const double thickness = tree.distance((1.0 / 3) * (a + b + c));
    least = std::fmin(least, thickness);
    report.mean_thickness += thickness * size;
    area += size;
  }
  report.least_thickness = least;
}

/// Writes the parts anew, each with its cavity behind its own triangles.
class Rebuilder {
 public:
  Rebuilder(Solid& solid, const std::vector<Cavity>& cavities, const Execution& execution)
      : solid_(solid), cavities_(cavities), pacer_(execution), mesh_(std::make_shared<Mesh>(*solid.source)) {}

  void run() {
    const std::vector<Run> runs = runs_of_parts(solid_);
    mesh_->material.resize(mesh_->triangles.size(), kNoIndex);
    mesh_->node.resize(mesh_->triangles.size(), 0);
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
    solid_.source = std::move(mesh_);
  }

 private:
  void reserve() {
    std::size_t count = solid_.triangles.size(), corners = 0;
    for (const Cavity& cavity : cavities_) {
      count += cavity.surface.triangles.size();
      corners += cavity.surface.positions.size();
    }
    triangles_.reserve(count);
    wedges_.reserve(count);
    material_.reserve(count);
    edges_.reserve(count);
    shell_.reserve(count);
    part_.reserve(count);
    solid_.positions.reserve(solid_.positions.size() + corners);
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
    const auto first_wedge = static_cast<std::uint32_t>(mesh_->positions.size());
    Part& part = solid_.parts[cavity.part];
    add_wedges(cavity.surface);
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
      add_source_triangle(wedges, part);
    }
  }

  /// Corners of the cavity as wedges: normals that are means by area, no texture, white.
  void add_wedges(const InnerSurface& surface) {
    std::vector<Vec3d> normals(surface.positions.size());
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      const auto [a, b, c] = corners_of(surface, t);
      for (const std::uint32_t corner : surface.triangles[t])
        normals[corner] = normals[corner] + cross(b - a, c - a);
    }
    mesh_->positions.insert(mesh_->positions.end(), surface.positions.begin(), surface.positions.end());
    Attributes& a = mesh_->attributes;
    // Any direction along the surface: nothing of a texture is shown there.
    const auto tangent = [](const Vec3d& n) {
      const Vec3d across = std::fabs(n.x) < 0.7 ? cross(n, Vec3d{1, 0, 0}) : cross(n, Vec3d{0, 1, 0});
      return (1 / length(across)) * across;
    };
    for (const Vec3d& sum : normals) {
      pacer_.step(8);
      const double size = length(sum);
      const Vec3d n = size > 0 ? (1 / size) * sum : Vec3d{0, 1, 0};
      if (!a.normals.empty())
        a.normals.push_back({static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)});
      if (a.tangents.empty()) continue;
      const Vec3d t = tangent(n);
      a.tangents.push_back({static_cast<float>(t.x), static_cast<float>(t.y), static_cast<float>(t.z), 1});
    }
    const std::size_t count = mesh_->positions.size();
    for (auto& set : a.uvs) set.resize(count, {0, 0});
    for (auto& set : a.colors) set.resize(count, {1, 1, 1, 1});
  }

  void add_source_triangle(const std::array<std::uint32_t, 3>& wedges, const Part& part) {
    mesh_->triangles.push_back(wedges);
    mesh_->material.push_back(kCavityMaterial);
    mesh_->node.push_back(part.node);
    if (!mesh_->triangle_color.empty())
      mesh_->triangle_color.push_back(
          {part.color.value_or(LinearColor{}), static_cast<std::uint16_t>(part.color.has_value())});
  }

  Solid& solid_;
  const std::vector<Cavity>& cavities_;
  Pacer pacer_;
  std::shared_ptr<Mesh> mesh_;
  std::vector<std::array<VertexId, 3>> triangles_;
  std::vector<std::array<std::uint32_t, 3>> wedges_, edges_;
  std::vector<std::uint32_t> material_, shell_, part_;
};

}  // namespace

Solid hollowed(Solid solid, const HollowOptions& options, const Execution& execution) {
  if (!options.any()) return solid;
  Pacer pacer(execution);
  SolidReport& report = solid.report;
  const std::vector<Run> runs = runs_of_parts(solid);
  const auto thickness_of = [&](const Part& part) {
    return options.thickness > 0 ? options.thickness : options.fraction * part.box.longest_side();
  };
  const auto may = [&](const Part& part) {
    const Vec3d size = part.box.size();
    return part.shells.size() == 1 && std::fmin(size.x, std::fmin(size.y, size.z)) > 2 * thickness_of(part);
  };
  std::uint32_t waiting = 0;
  for (const Part& part : solid.parts) waiting += may(part);
  const std::uint32_t asked = waiting;
  std::uint32_t left = options.max_all;
  std::vector<Cavity> cavities;
  double area = 0;
  for (std::size_t p = 0; p < solid.parts.size(); ++p) {
    Part& part = solid.parts[p];
    if (!may(part)) continue;
    execution.poll();
    const hollow_detail::InnerSurfaceLimits limits{std::min(options.max_triangles, left / waiting--)};
    if (limits.triangles < kLeastTriangles) continue;
    const TriangleTree tree = tree_of(solid, runs[p], execution);
    Cavity cavity{p, inner_surface(tree, part.box, thickness_of(part), limits, execution), {}};
    const double volume = volume_of(cavity.surface, part.box.center());
    // A surface that crosses itself may enclose less than its deep places do.
    if (cavity.surface.triangles.empty() || volume >= part.volume) continue;
    left -= static_cast<std::uint32_t>(cavity.surface.triangles.size());
    execution.made(Product::kSurfaceTriangles, cavity.surface.triangles.size());
    cavity.shell_of_triangle = shells_of(cavity.surface, cavity.shells);
    measure(cavity.surface, tree, report, area, pacer);
    part.volume -= volume;
    report.absolute_volume += volume;
    ++report.parts_hollowed;
    report.hollow_triangles += cavity.surface.triangles.size();
    report.hollow_volume += volume;
    cavities.push_back(std::move(cavity));
  }
  if (report.parts_hollowed < asked)
    report.notes.push_back(
        std::to_string(asked - report.parts_hollowed) + " of " + std::to_string(asked) +
        " closed parts stayed solid: nowhere are they thick enough for walls, or there are too "
        "many parts.");
  if (cavities.empty()) return solid;
  report.area += area;
  report.volume = 0;
  for (const Part& part : solid.parts) report.volume += part.volume;
  report.mean_thickness /= area;
  if (options.thickness > 0 && report.mean_thickness > 2 * options.thickness)
    report.notes.push_back("Walls are " +
                           std::to_string(std::lround(report.mean_thickness / options.thickness)) +
                           " times as thick as 'shell' asks: thinner ones take more triangles than may be.");
  Rebuilder(solid, cavities, execution).run();
  return solid;
}

}  // namespace fracture
