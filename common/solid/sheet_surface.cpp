#include "common/solid/sheet_surface.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/solid/polled.hpp"
#include "common/solid/same_positions.hpp"

namespace fracture {
namespace {

using solid_detail::filled, solid_detail::for_each_polled;

/// m², from the positions in the file.
double area_of(const Mesh& mesh, std::uint32_t triangle) {
  const auto& wedges = mesh.triangles[triangle];
  const Vec3d a = to_double(mesh.positions[wedges[0]]);
  return 0.5 *
         length(cross(to_double(mesh.positions[wedges[1]]) - a, to_double(mesh.positions[wedges[2]]) - a));
}

/// Makes one vertex of all corners with the same position. Vertices are in the order of their first corners.
void number_vertices(const Mesh& mesh, const std::vector<std::uint32_t>& triangles, Solid& surface,
                     const Execution& execution) {
  std::vector<Vec3f> corners;
  corners.reserve(3 * triangles.size());
  for_each_polled(execution, triangles.size(), [&](std::size_t k) {
    for (const std::uint32_t wedge : mesh.triangles[triangles[k]]) corners.push_back(mesh.positions[wedge]);
  });
  const auto first = solid_detail::first_of_same(corners, execution);
  std::vector<VertexId> vertex = filled(execution, corners.size(), VertexId{kNoIndex});
  surface.triangles.resize(triangles.size());
  for_each_polled(execution, corners.size(), [&](std::size_t c) {
    VertexId& of_position = vertex[first[c]];
    if (of_position == VertexId{kNoIndex}) {
      of_position = VertexId{surface.positions.size()};
      surface.positions.push_back(corners[c]);
      surface.box.add(to_double(corners[c]));
    }
    surface.triangles[c / 3][c % 3] = of_position;
  });
}

/// Numbers the edges in ascending order of their vertices.
void number_edges(Solid& surface, const Execution& execution) {
  struct Use {
    VertexId low, high;
    std::uint32_t half_edge;
  };
  std::vector<Use> uses;
  uses.reserve(3 * surface.triangles.size());
  for_each_polled(execution, surface.triangles.size(), [&](std::size_t t) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(surface.triangles[t][k], surface.triangles[t][(k + 1) % 3]);
      uses.push_back({low, high, static_cast<std::uint32_t>(3 * t + k)});
    }
  });
  sort_with_polls(execution, uses.begin(), uses.end(), [](const Use& a, const Use& b) {
    if (a.low != b.low) return a.low < b.low;
    return a.high != b.high ? a.high < b.high : a.half_edge < b.half_edge;
  });
  surface.edges.resize(surface.triangles.size());
  for_each_polled(execution, uses.size(), [&](std::size_t k) {
    const Use& use = uses[k];
    if (k == 0 || use.low != uses[k - 1].low || use.high != uses[k - 1].high)
      surface.edge_vertices.push_back({use.low, use.high});
    surface.edges[use.half_edge / 3][use.half_edge % 3] =
        static_cast<std::uint32_t>(surface.edge_vertices.size() - 1);
  });
}

}  // namespace

std::shared_ptr<const Sheets> make_sheets(std::shared_ptr<const Mesh> source,
                                          const std::vector<std::uint32_t>& triangles, const Box& solid_box,
                                          bool whole, const Execution& execution) {
  auto sheets = std::make_shared<Sheets>();
  sheets->whole = whole;
  for_each_polled(execution, triangles.size(), [&](std::size_t k) {
    const double area = area_of(*source, triangles[k]);
    if (!(area > 0)) return;
    sheets->area += area;
    sheets->triangles.push_back(triangles[k]);
  });
  if (sheets->triangles.empty()) return nullptr;
  auto surface = std::make_shared<Solid>();
  surface->box = solid_box;
  number_vertices(*source, sheets->triangles, *surface, execution);
  number_edges(*surface, execution);
  for_each_polled(execution, sheets->triangles.size(), [&](std::size_t k) {
    const std::uint32_t t = sheets->triangles[k];
    surface->wedges.push_back(source->triangles[t]);
    surface->material.push_back(t < source->material.size() ? source->material[t] : kNoIndex);
  });
  surface->shell.assign(sheets->triangles.size(), 0);
  surface->part.assign(sheets->triangles.size(), 0);
  Part& part = surface->parts.emplace_back();
  part.shells = {0};
  part.box = surface->box;
  surface->layers = 1;
  surface->source = std::move(source);
  sheets->surface = std::move(surface);
  return sheets;
}

}  // namespace fracture
