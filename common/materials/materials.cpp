#include "common/materials/materials.hpp"

#include <vector>

namespace fracture {
namespace {

// Restitution: solid spheres made of these materials have a restitution of 0.5 to 0.9. Shards land on edges and corners and lose
// most of it, so the values are a third of the values for spheres, in the same order. The roughness of cuts is chosen by eye
// (scripts/gallery). Bricks separate at their mortar planes, which are flat.
std::vector<MaterialPreset> make_presets() {
  std::vector<MaterialPreset> presets;

  // Cracks start at the hit. Thick parts break along smooth waves (conchoidal fracture), which fade out in panes and walls.
  RadialPattern glass;
  glass.around = RadialPattern::Around::kShape;
  glass.jitter = 0.9;
  glass.merge = 0.7;
  presets.push_back(
      {"glass",
       "Panes break into rings and spokes, rods into lengths, vessels into long shards, and lumps along smooth waves.",
       glass,
       0,
       1,
       {0.08, 1.2, 1},
       {2500, 0.4, 0.25, 45e6},
       {"#cfe6dd", 0.3, 1, 0.05, 0, 0.05, 0.4},
       "EN 572-1 (soda-lime: 2500 kg/m3, bending strength 45 MPa); kinetic friction of glass on glass 0.4 "
       "(CRC Handbook)",
       std::nullopt,
       0.02});

  presets.push_back(
      {"wood",
       "Splinters along the grain.",
       UniformPattern{},
       0,
       8,
       {0.03, 6, 1},
       {500, 0.4, 0.15, 2.6e6},
       {"#c79a63", 0.6, 1.2, 0.85, 0, 0.6},
       "Wood Handbook, FPL-GTR-190 (pine: 500 kg/m3 at 12 % moisture, tension across the grain 2.6 MPa)"});

  ClusteredPattern concrete, chunks;
  chunks.share = 0.5;  // large blocks have enough cells to be ragged
  presets.push_back({"concrete",
                     "Large ragged blocks with rubble between them.",
                     chunks,
                     0,
                     1,
                     {0.03, 8, 1},
                     {2400, 0.65, 0.1, 2.6e6},
                     {"#8d8a84", 0.5, 0.8, 0.95, 0, 0.9},
                     "EN 1991-1-1 (24 kN/m3), EN 1992-1-1 table 3.1 (C25/30: mean tensile strength 2.6 MPa)",
                     std::nullopt,
                     0,
                     {6, 1.8}});

  presets.push_back({"stone",
                     "Ragged chunks with the sizes of blasted rock.",
                     UniformPattern{},
                     0,
                     1,
                     {0.04, 8, 1},
                     {2700, 0.65, 0.15, 10e6},
                     {"#7d7a76", 0.7, 0.8, 0.9, 0, 0.8},
                     "EN 1991-1-1 (granite 27 kN/m3); Brazilian tensile strength of granite about 10 MPa",
                     std::nullopt,
                     0,
                     {6, 1}});

  BrickPattern brick;
  brick.jitter = 0.05;
  presets.push_back(
      {"brick",
       "Masonry in running bond: lumps with toothed edges, and whole, half and crushed bricks at the hit.",
       brick,
       0,
       1,
       {},
       {1900, 0.65, 0.1, 0.3e6},
       {"#9c4a33", 0.6, 0.8, 0.95, 0, 0.9},
       "EN 1991-1-1 (clay bricks 19 kN/m3); bond of mortar to brick 0.1 to 0.5 MPa (EN 1996-1-1)"});

  ImpactPattern ceramic;
  ceramic.exponent = 1.5;
  ceramic.share = 0.55;
  presets.push_back({"ceramic",
                     "Small shards at the impact, large shards farther away.",
                     ceramic,
                     0,
                     1,
                     {0.012, 6, 1},
                     {2400, 0.5, 0.2, 35e6},
                     {"#e9dfd0", 0.25, 1, 0.85, 0, 0.15},
                     "Porcelain: 2400 kg/m3, bending strength 35 to 70 MPa (IEC 60672-3, C 110 to C 120)",
                     std::nullopt,
                     0.04});

  // Torn edges are clean and follow the long cells back and forth. Bare steel reflects 0.55 to 0.6 of visible light (CRC
  // Handbook, iron).
  presets.push_back(
      {"metal",
       "Sheet metal torn into large plates and strips with saw-toothed edges; nothing bends.",
       UniformPattern{},
       0,
       3,
       {},
       {7850, 0.57, 0.2, 360e6},
       {"#c5c6c7", 0.1, 1, 0.4, 1, 0.3},
       "EN 1991-1-1 (steel 78.5 kN/m3); S235: tensile strength 360 MPa (EN 10025-2); kinetic friction "
       "of steel on steel 0.57 (CRC Handbook)",
       std::nullopt,
       0.015,
       {6, 1.4}});

  // It breaks along its graphite flakes, which are grey and matt compared with the iron.
  presets.push_back({"cast_iron",
                     "Blocky pieces of similar size, with grainy fracture surfaces.",
                     UniformPattern{},
                     1,
                     1.5,
                     {0.02, 8, 1},
                     {7200, 0.5, 0.15, 200e6},
                     {"#a9abad", 0.1, 0.9, 0.75, 0.6, 0.6},
                     "EN 1561 (EN-GJL-200: tensile strength 200 MPa; 7200 kg/m3)"});

  // Few cracks, which run far, around a small crushed zone (Jordaan 2001, "Mechanics of ice-structure interaction").
  ImpactPattern ice;
  ice.exponent = 2.8;
  ice.share = 0.5;
  presets.push_back(
      {"ice",
       "Large clear blocks around a white crushed zone.",
       ice,
       0,
       1,
       {0.03, 3, 1},
       {917, 0.05, 0.1, 1.4e6},
       {"#d8ecf5", 0.3, 1.1, 0.4, 0, 0.15, 0.7, 0.4},
       "917 kg/m3 at 0 °C (CRC Handbook); tensile strength 1.4 MPa at -10 °C (Petrovic 2003); friction 0.02 "
       "to 0.1"});

  presets.push_back(
      {"plaster",
       "Crumbling lumps between large pieces.",
       concrete,
       0,
       1,
       {0.05, 6, 2},
       {1000, 0.6, 0.1, 1e6},
       {"#ece8df", 0.3, 1, 0.95, 0, 0.9},
       "EN 13279-1 (gypsum plaster B1: flexural strength at least 1 MPa); about 1000 kg/m3 when dry"});

  presets.push_back({"terracotta",
                     "Curved shards of pottery, with rough red clay inside.",
                     ceramic,
                     0,
                     1,
                     {0.02, 6, 2},
                     {1900, 0.6, 0.15, 10e6},
                     {"#b5653f", 0.35, 0.9, 0.9, 0, 0.8},
                     "Fired clay: 1800 to 2000 kg/m3 (EN 1991-1-1), bending strength about 10 MPa",
                     std::nullopt,
                     0.06});

  presets.push_back({"sandstone",
                     "Slabs along the bedding, with grainy faces.",
                     UniformPattern{},
                     1,
                     0.5,
                     {0.05, 6, 2},
                     {2300, 0.65, 0.1, 4e6},
                     {"#c8a878", 0.5, 0.9, 0.95, 0, 0.95},
                     "EN 1991-1-1 (sandstone 21 to 27 kN/m3); Brazilian tensile strength 2 to 6 MPa",
                     Vec3d{0, 1, 0}});

  presets.push_back({"crystal",
                     "Clear prisms with flat faces, longer than they are wide.",
                     UniformPattern{},
                     3,
                     2.5,
                     {},
                     {2650, 0.4, 0.3, 50e6},
                     {"#dcd3f0", 0.4, 1.2, 0.05, 0, 0.05, 0.5},
                     "Quartz: 2650 kg/m3 (CRC Handbook), tensile strength about 50 MPa",
                     Vec3d{0, 1, 0}});
  return presets;
}

const std::vector<MaterialPreset>& all() {
  static const std::vector<MaterialPreset> presets = make_presets();
  return presets;
}

}  // namespace

std::span<const MaterialPreset> material_presets() { return all(); }

const MaterialPreset* find_material_preset(std::string_view name) {
  for (const MaterialPreset& preset : all())
    if (name == preset.name) return &preset;
  return nullptr;
}

double usual_piece(std::string_view name) {
  struct Piece {
    std::string_view material;
    double size;
  };
  static constexpr Piece kPieces[] = {
      {"glass", 0.1},       {"wood", 0.1},      {"concrete", 0.3},  {"stone", 0.3}, {"brick", 0.24},
      {"ceramic", 0.03},    {"metal", 0.2},     {"cast_iron", 0.1}, {"ice", 0.2},   {"plaster", 0.1},
      {"terracotta", 0.05}, {"sandstone", 0.3}, {"crystal", 0.05}};
  for (const Piece& piece : kPieces)
    if (name == piece.material) return piece.size;
  return 0;
}

}  // namespace fracture
