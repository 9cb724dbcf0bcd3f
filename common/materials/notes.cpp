#include "common/materials/notes.hpp"

#include <stdexcept>
#include <string>

namespace fracture {
namespace {

struct Named {
  const char* material;
  MaterialNotes notes;
};

// Costs are printed by scripts/lib/parameters_page.py --measure.
constexpr Named kNotes[] = {
    {"glass",
     {"panes, bottles, lamps",
      "An impact on a plate makes star-shaped cracks with rings around them: Vandenberghe, Vermorel and Villermaux (2013), Star-shaped crack pattern of broken windows.",
      1.3}},
    {"wood",
     {"planks, posts, crates, furniture",
      "Wood splits along the grain at a twentieth of the stress that breaks it across the grain: Wood Handbook, FPL-GTR-190.",
      2.0}},
    {"concrete",
     {"pillars, slabs, bunkers",
      "A mixture of many sizes, chosen by eye between the distribution of a single process and that of Mott and Linfoot (1943).",
      2.9}},
    {"stone",
     {"statues, rocks, blocks",
      "Sizes as in blasted granitic gneiss: Astrom et al. (2004). Distribution: Grady and Kipp (1985).",
      3.3}},
    {"brick",
     {"walls, houses, chimneys",
      "Masonry breaks along its joints if mortar is weaker than brick: EN 1996-1-1.", 2.1}},
    {"ceramic",
     {"plates, vases, tiles",
      "A higher strain rate makes smaller shards, and the rate falls with distance from the hit: Grady (1982), Local inertial effects in dynamic fragmentation.",
      1.5}},
    {"metal",
     {"doors, tanks, cars; engines (with `shell=0`)",
      "Strips run in the direction in which a shell tears: Mott (1947), Fragmentation of shell cases. The jagged edges are chosen by eye.",
      2.1}},
    {"cast_iron", {"machines, bells, grates", "Brittle, with no preferred direction; chosen by eye.", 1.9}},
    {"ice",
     {"icebergs, ice sheets, icicles",
      "A crushed zone with few cracks beyond it: Jordaan (2001), Mechanics of ice-structure interaction.",
      1.3}},
    {"plaster", {"mouldings, busts, plastered walls", "Like concrete, but weaker; chosen by eye.", 1.6}},
    {"terracotta", {"pots, roof tiles, amphoras", "Like ceramic.", 2.5}},
    {"sandstone",
     {"cliffs, temples, statues", "Sandstone splits along its bedding planes; chosen by eye.", 2.7}},
    {"crystal", {"gems, quartz stalagmites", "Prisms, the shape in which quartz grows; chosen by eye.", 1.3}},
};

}  // namespace

const MaterialNotes& notes_of(const MaterialPreset& preset) {
  for (const Named& named : kNotes)
    if (std::string_view(preset.name) == named.material) return named.notes;
  throw std::logic_error(std::string("this material lacks notes: ") + preset.name);
}

}  // namespace fracture
