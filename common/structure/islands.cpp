#include "common/structure/islands.hpp"

#include <algorithm>
#include <cmath>

#include "common/bvh/box_tree.hpp"
#include "common/bvh/triangle_distance.hpp"
#include "common/contacts/near_triangles.hpp"
#include "common/contacts/vertex_windings.hpp"

namespace fracture {

using contacts_detail::Owner;
using contacts_detail::PartSurfaces;

namespace {

Vec3f placed(const Fragment& f, std::uint32_t vertex) {
  const Vec3d p = to_double(f.positions[vertex]) + f.pivot;
  return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}

/// Makes a solid with the fields that PartSurfaces reads, with one part for each island.
Solid solid_of(std::span<const Fragment* const> fragments, std::span<const std::uint32_t> islands,
               const Execution& execution) {
  Solid solid;
  Pacer pacer(execution);
  for (const std::uint32_t island : islands) {
    const Fragment& f = *fragments[island];
    execution.made(Product::kSurfaceTriangles, f.indices.size() / 3);
    const std::size_t first = solid.positions.size();
    Part part;
    for (std::uint32_t v = 0; v < f.positions.size(); ++v) {
      pacer.step();
      solid.positions.push_back(placed(f, v));
      part.box.add(to_double(solid.positions.back()));
    }
    for (std::size_t t = 0; t < f.indices.size(); t += 3) {
      pacer.step();
      std::array<VertexId, 3> corners;
      for (std::size_t c = 0; c < 3; ++c) corners[c] = VertexId{first + f.topology[f.indices[t + c]]};
      solid.triangles.push_back(corners);
      solid.part.push_back(static_cast<std::uint32_t>(solid.parts.size()));
    }
    solid.parts.push_back(std::move(part));
  }
  return solid;
}

/// The boxes of a solid's triangles.
std::vector<Box> boxes_of(const PartSurfaces& surfaces, const Execution& execution) {
  Pacer pacer(execution);
  std::vector<Box> boxes;
  boxes.reserve(surfaces.solid().triangles.size());
  for (std::uint32_t t = 0; t < surfaces.solid().triangles.size(); ++t) {
    pacer.step();
    boxes.push_back(box_of(surfaces.corners(t)));
  }
  return boxes;
}

}  // namespace

struct Islands::Surfaces {
  Surfaces(Solid made, const Execution& execution)
      : solid(std::move(made)),
        surfaces(solid, execution),
        triangles(boxes_of(surfaces, execution), execution) {
    double farthest = 0;
    for (const Part& part : solid.parts) {
      size = std::max(size, part.box.longest_side());
      for (int axis = 0; axis < 3; ++axis)
        farthest = std::max({farthest, std::fabs(part.box.min[axis]), std::fabs(part.box.max[axis])});
    }
    rounding = kRoundingOfDistances * farthest;
  }
  /// Exceeds the rounding error of a distance, relative to the largest coordinate.
  static constexpr double kRoundingOfDistances = 1e-12;
  const Solid solid;
  const PartSurfaces surfaces;
  const BoxTree triangles;
  double size = 0;      ///< m
  double rounding = 0;  ///< m: distances that differ by less may be equal
};

Islands::Islands(std::span<const Fragment* const> fragments, double rounding, const Execution& execution)
    : fragments_(fragments), rounding_(rounding), execution_(execution), pacer_(execution) {}
Islands::~Islands() = default;

Islands::OfCell& Islands::islands_of(std::uint32_t cell, std::span<const std::uint32_t> islands) {
  OfCell& of_cell = of_cell_[cell];
  if (of_cell.boxes.empty())
    for (const std::uint32_t island : islands) {
      const Fragment& f = *fragments_[island];
      Box box;
      for (const Vec3f& p : f.positions) box.add(to_double(p));
      pacer_.step(1 + f.positions.size() / 4);
      of_cell.boxes.push_back({f.pivot + box.min, f.pivot + box.max});
    }
  return of_cell;
}

/// Returns the nearest island, and of several equally near ones the first. If all are far away, returns the first island.
std::size_t Islands::nearest(const Surfaces& surfaces, const Vec3d& place) {
  std::size_t nearest = 0;
  double least = surfaces.size;
  surfaces.triangles.nearest(place, least, surfaces.rounding, [&](std::uint32_t t) {
    pacer_.step(8);
    const std::size_t island = surfaces.solid.part[t];
    const double apart =
        distance_of_triangles({place, place, place}, surfaces.surfaces.corners(t), least + surfaces.rounding);
    if (apart < least || (apart == least && island < nearest)) {
      least = apart;
      nearest = island;
    }
    return least;
  });
  return nearest;
}

std::size_t Islands::count_near(std::uint32_t cell, std::span<const std::uint32_t> islands, const Box& box) {
  if (islands.size() == 1) return 1;
  const OfCell& of_cell = islands_of(cell, islands);
  const Vec3d off{4 * rounding_, 4 * rounding_, 4 * rounding_};
  return static_cast<std::size_t>(
      std::count_if(of_cell.boxes.begin(), of_cell.boxes.end(), [&](const Box& of) {
        return of.intersects({box.min - off, box.max + off});
      }));
}

std::uint32_t Islands::pick(std::uint32_t cell, std::span<const std::uint32_t> islands, const Vec3d& place,
                            bool is_on) {
  if (islands.size() == 1) return islands[0];
  OfCell& of_cell = islands_of(cell, islands);
  const Vec3d off{4 * rounding_, 4 * rounding_, 4 * rounding_};
  std::size_t around = 0, last = 0;
  for (std::size_t k = 0; k < islands.size(); ++k)
    if (of_cell.boxes[k].intersects({place - off, place + off})) {
      ++around;
      last = k;
    }
  if (around == 1) return islands[last];
  if (!of_cell.surfaces)
    of_cell.surfaces = std::make_unique<Surfaces>(solid_of(fragments_, islands, execution_), execution_);
  const Surfaces& surfaces = *of_cell.surfaces;
  if (!is_on) {
    const Vec3d p = to_double(
        Vec3f{static_cast<float>(place.x), static_cast<float>(place.y), static_cast<float>(place.z)});
    for (std::uint32_t k = 0; k < islands.size(); ++k)
      if (contacts_detail::winding_around(surfaces.surfaces, k, p, Owner::kA, pacer_) != 0) return islands[k];
  }
  return islands[nearest(surfaces, place)];
}

}  // namespace fracture
