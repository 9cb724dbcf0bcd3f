#include "common/solid/open_pieces.hpp"

#include <cmath>
#include <string>

#include "common/base/words.hpp"
#include "common/solid/faults.hpp"
#include "common/solid/polled.hpp"

namespace fracture::solid_detail {
namespace {

/// Minimum area of a fill, as a share of the piece's own area. The fills of seams and slits have less.
constexpr double kLeastFill = 1e-5;

/// The areas of each shell.
struct Areas {
  double source = 0, fill = 0;  ///< m²
  bool filled = false;          ///< has fill triangles, possibly without area
};

std::vector<Areas> areas_of(const Surface& surface, const Shells& shells, const Execution& execution) {
  std::vector<Areas> areas = filled(execution, shells.list.size(), Areas{});
  for_each_polled(execution, surface.triangles.size(), [&](std::size_t t) {
    const Triangle& c = surface.triangles[t];
    const Vec3d a = to_double(surface.positions[c[0]]);
    const double area =
        0.5 * length(cross(to_double(surface.positions[c[1]]) - a, to_double(surface.positions[c[2]]) - a));
    Areas& of = areas[shells.of_triangle[t]];
    const bool is_fill = surface.source[t] == kNoIndex;
    of.filled |= is_fill;
    (is_fill ? of.fill : of.source) += area;
  });
  return areas;
}

}  // namespace

std::vector<std::uint8_t> find_open_sheets(const Surface& surface, const Shells& shells, double thickness,
                                           const Walled& walled, SolidReport& report,
                                           const Execution& execution) {
  const std::vector<Areas> areas = areas_of(surface, shells, execution);
  std::vector<std::uint8_t> is_sheet = filled<std::uint8_t>(execution, shells.list.size(), 0);
  std::uint64_t bodies = 0, triangles = 0;
  double most = 0;  // maximum of volume / volume of a slab
  TriangleId first = kNoTriangle;
  for_each_polled(execution, shells.list.size(), [&](std::size_t s) {
    const Shell& shell = shells.list[s];
    const double slab = thickness * areas[s].source;
    const bool is_walled =
        (!walled.lids.empty() && walled.lids[s]) || (!walled.rooms.empty() && walled.rooms[s]);
    is_sheet[s] = shell.flat || is_walled || (areas[s].filled && std::fabs(shell.volume) < slab);
    if (is_sheet[s] || areas[s].fill <= kLeastFill * areas[s].source) return;
    if (bodies++ == 0) first = shell.first;
    triangles += shell.triangles;
    most = std::fmax(most, std::fabs(shell.volume) / slab);
  });
  if (bodies > 0)
    report.remarks.warn("'thickness' made no slab from " + counted(bodies, "open piece", "open pieces") +
                        " (" + counted(triangles, "triangle", "triangles") + " when closed, the first at " +
                        place(surface.positions[surface.triangles[first][0]]) +
                        "). Instead, the holes were filled and the inside is solid, because this gives " +
                        (bodies > 1 ? "up to " : "") + short_number(most) + " times the volume of a slab " +
                        short_number(thickness) +
                        " m thick. If you want a curved sheet, give it a thickness in a modelling tool.");
  return is_sheet;
}

}  // namespace fracture::solid_detail
