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
      "Star-shaped cracks in a plate that was hit, with rings around them: Vandenberghe, Vermorel and Villermaux (2013), Star-shaped crack pattern of broken windows.",
      1.3}},
    {"wood",
     {"planks, posts, crates, furniture",
      "Fibres part along the grain, which takes a twentieth of the stress of breaking across it: Wood Handbook, FPL-GTR-190.",
      2.0}},
    {"concrete",
     {"pillars, slabs, bunkers",
      "Many sizes at once, between those of a single process and those of Mott and Linfoot (1943); by eye.",
      2.9}},
    {"stone",
     {"statues, rocks, blocks",
      "Sizes of blasted granitic gneiss: Astrom et al. (2004); their distribution: Grady and Kipp (1985).",
      3.3}},
    {"brick",
     {"walls, houses, chimneys", "Masonry parts where mortar is weaker than brick: EN 1996-1-1.", 2.1}},
    {"ceramic",
     {"plates, vases, tiles",
      "Faster strain makes smaller shards, and the rate falls with the distance from the hit: Grady (1982), Local inertial effects in dynamic fragmentation.",
      1.5}},
    {"metal",
     {"doors, tanks, cars; engines with `shell=0`",
      "Strips in the direction in which a shell tears: Mott (1947), Fragmentation of shell cases; jags by eye.",
      2.1}},
    {"cast_iron", {"machines, bells, grates", "Brittle, without a direction; by eye.", 1.9}},
    {"ice",
     {"icebergs, sheets on water, icicles",
      "A crushed zone, with few cracks beyond it: Jordaan (2001), Mechanics of ice-structure interaction.",
      1.3}},
    {"plaster", {"mouldings, busts, plastered walls", "Like concrete, but weaker; by eye.", 1.6}},
    {"terracotta", {"pots, roof tiles, amphoras", "Like ceramic.", 2.5}},
    {"sandstone", {"cliffs, temples, statues", "Parts along its bedding; by eye.", 2.7}},
    {"crystal", {"gems, stalagmites of quartz", "Prisms, as quartz grows; by eye.", 1.3}},
};

}  // namespace

const MaterialNotes& notes_of(const MaterialPreset& preset) {
  for (const Named& named : kNotes)
    if (std::string_view(preset.name) == named.material) return named.notes;
  throw std::logic_error(std::string("there are no notes on the material ") + preset.name);
}

}  // namespace fracture
