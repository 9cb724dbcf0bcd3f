#include "common/solid/enclosures.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "common/base/words.hpp"
#include "common/solid/faults.hpp"
#include "common/solid/polled.hpp"

namespace fracture::solid_detail {
namespace {

/// The largest value of the parameter `thickness`, m.
constexpr double kMostThickness = 1000;

/// The thickness that is offered for the walls, m: one digit, so that people can read and change it.
double offered_thickness(double longest) {
  char text[32];
  std::snprintf(text, sizeof text, "%.0e", kWallShare * longest);
  return std::fmin(std::strtod(text, nullptr), kMostThickness);
}

void offer_walls(const char* kind, const Enclosures& enclosures, const std::string& found,
                 SolidReport& report) {
  const double thickness = offered_thickness(enclosures.longest);
  if (!(thickness > 0)) return;  // smaller than every float
  report.choices.push_back({.kind = kind,
                            .parameters = {{"thickness", thickness}},
                            .text = found + " thickness=" + short_number(thickness) + " makes walls of " +
                                    short_number(thickness) + " m instead and keeps the space inside."});
}

std::string first_at(const Enclosures& enclosures, const Surface& surface) {
  return place(surface.positions[surface.triangles[enclosures.first][0]]);
}

}  // namespace

Enclosures find_large_lids(const Surface& surface, const Shells& shells, const std::vector<TriangleId>& fills,
                           const Execution& execution) {
  Enclosures lids;
  if (fills.empty()) return lids;
  std::vector<double> lid_area = filled(execution, fills.size(), 0.0);
  std::vector<double> fill_area = filled(execution, shells.list.size(), 0.0);
  std::size_t lid = 0;
  for (std::size_t t = fills.front(); t < surface.triangles.size(); ++t) {
    if (t % 16384 == 0) execution.poll();
    if (lid + 1 < fills.size() && t == fills[lid + 1]) ++lid;
    const double area = area_of(surface, t);
    lid_area[lid] += area;
    fill_area[shells.of_triangle[t]] += area;
  }
  lids.has = filled<std::uint8_t>(execution, shells.list.size(), 0);
  for_each_polled(execution, fills.size(), [&](std::size_t k) {
    const std::uint32_t s = shells.of_triangle[fills[k]];
    const Shell& shell = shells.list[s];
    const double own = shell.area - fill_area[s];
    if (shell.flat || !(lid_area[k] > kLargeLid * own)) return;
    if (!lids.has[s]) ++lids.count;
    lids.has[s] = 1;
    lids.longest = std::fmax(lids.longest, shell.box.longest_side());
    if (const double share = own > 0 ? lid_area[k] / own : HUGE_VAL; share > lids.share) {
      lids.share = share;
      lids.first = fills[k];
    }
  });
  return lids;
}

Enclosures find_rooms(const Shells& shells, const Nesting& nesting, const Enclosures& lids,
                      const Execution& execution) {
  Enclosures rooms;
  double area = 0;
  const std::size_t count = shells.list.size();
  for_each_polled(execution, count, [&](std::size_t s) { area += shells.list[s].area; });
  for_each_polled(execution, count, [&](std::size_t s) {
    const Shell& shell = shells.list[s];
    if (shell.flat || !(shell.volume < 0) || !nesting.reversed[s] || nesting.cavity_of[s] != kNoIndex ||
        (lids.any() && lids.has[s]) || !(shell.area > kRoomShare * area))
      return;
    if (!rooms.any()) rooms.has = filled<std::uint8_t>(execution, count, 0);
    rooms.has[s] = 1;
    if (rooms.count++ == 0) rooms.first = shell.first;
    rooms.longest = std::fmax(rooms.longest, shell.box.longest_side());
  });
  return rooms;
}

void offer_walls_of_rooms(const Enclosures& rooms, const Surface& surface, SolidReport& report) {
  if (!rooms.any()) return;
  offer_walls("room", rooms,
              counted(rooms.count, "closed piece faces", "closed pieces face") + " inwards, the first at " +
                  first_at(rooms, surface) + ", like a room that is seen from inside. " +
                  (rooms.count == 1 ? "Its faces were turned, so it is a solid block."
                                    : "Their faces were turned, so they are solid blocks."),
              report);
}

void offer_walls_instead_of_lids(const Enclosures& lids, const Surface& surface, SolidReport& report) {
  if (!lids.any()) return;
  const std::string share =
      std::isfinite(lids.share) ? short_number(std::round(100 * lids.share)) + " %" : "more than 100 %";
  offer_walls("lid", lids,
              counted(lids.count, "open piece was closed by a large lid, so it is",
                      "open pieces were closed by large lids, so they are") +
                  " solid inside. The largest lid, at " + first_at(lids, surface) + ", has " + share +
                  " of the area of its piece.",
              report);
}

}  // namespace fracture::solid_detail
