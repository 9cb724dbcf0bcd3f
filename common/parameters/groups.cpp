#include "common/parameters/groups.hpp"

namespace fracture {
namespace {

constexpr GroupedParameter kMesh[] = {
    {"format", "file type, extension"},
    {"unit", "scale, inches, feet, metres, meters, centimetres, millimetres, units"},
    {"up", "up axis, z-up, orientation, rotate"},
    {"nodes", "objects, selection, only"},
    {"materials", "material slots, slots"},
    {"proxies", "lod, levels of detail, collision meshes, ucx, colonly, proxy geometry"},
    {"repair", "fix, close holes, fill holes, watertight, manifold"},
    {"weld_tolerance", "merge vertices, weld, crack, seam"},
    {"sheets", "planes, panes, leaves, decals, cloth, cards, open surfaces"},
    {"thickness", "solidify, sheet, plane, cloth, leaf"},
    {"shell", "hollow, wall, wall thickness, vessel"},
    {"shell_fraction", "hollow, wall, relative wall thickness"},
    {"shell_ball", "hollow, which parts become hollow"},
    {"contact_gap", "touching, gap, neighbours"},
};
constexpr GroupedParameter kSeveral[] = {
    {"assign", "several materials, materials by part, material of a node, wood and glass"},
};
constexpr GroupedParameter kCuts[] = {
    {"material", "substance, preset, kind"},
    {"pattern", "style, voronoi, algorithm, arrangement"},
    {"sites", "cells, seeds, voronoi points"},
    {"levels", "hierarchy, clusters of clusters, coarse to fine"},
    {"seed", "random, variation, variant, shuffle"},
    {"lloyd", "relax, relaxation, even, regular, smooth"},
    {"density_from", "vertex paint, weight map, mask"},
    {"stretch", "elongate, fibre, fiber, splinters, anisotropy"},
    {"grain", "fibre direction, fiber direction"},
    {"grain_of", "fibre direction, fiber direction"},
    {"stretch_matrix", "shear, transform, anisotropy"},
};
constexpr GroupedParameter kChunks[] = {
    {"cells_per_fragment", "chunky, ragged, irregular, glue, concave"},
    {"size_spread", "uneven sizes, variation of sizes, distribution"},
};
constexpr GroupedParameter kPatterns[] = {
    {"points", "custom sites, own points, positions"},
    {"impacts", "impact, hit, hit point, strike, bullet"},
    {"radius", "size of the hit, impact radius"},
    {"exponent", "fineness, falloff, concentration"},
    {"share", "fineness, concentration, how many near the hit"},
    {"clusters", "number of clusters"},
    {"around", "rings around"},
    {"axis", "direction of the rings"},
    {"spokes", "cracks, rays, radial cracks"},
    {"rings", "circles, concentric cracks"},
    {"growth", "ring width"},
    {"merge", "long shards"},
    {"crushed", "crumbs, dust, powder, debris"},
    {"jitter", "randomness, irregular"},
    {"cell", "brick size, box size, grid size"},
    {"bond", "masonry, brick offset, running bond"},
    {"mortar", "joint, joints, grout"},
    {"normals", "slicing directions, cutting planes"},
    {"spacing", "slice thickness, distance of planes"},
    {"tilt", "angle, slope"},
};
constexpr GroupedParameter kRough[] = {
    {"rough_amplitude", "roughness, noise, displacement, jagged, bumpy"},
    {"rough_frequency", "noise scale, noise size"},
    {"rough_octaves", "noise detail"},
};
constexpr GroupedParameter kSizes[] = {
    {"fragments", "pieces, shards, chunks, count, number, amount, number of pieces"},
    {"parts", "separate parts, loose parts, islands"},
    {"instances", "copies, duplicates, linked meshes, instancing, repeated objects"},
    {"min_volume", "smallest piece, crumbs, dust"},
    {"min_fraction", "smallest piece, crumbs, dust"},
    {"min_of_mean", "smallest piece, crumbs, dust"},
    {"max_volume", "largest piece, biggest piece"},
    {"max_fragments", "limit of pieces, budget"},
    {"max_triangles", "polygons, polycount, faces, budget"},
};
constexpr GroupedParameter kKept[] = {
    {"keep_center", "protect, preserve, whole, uncut"},
    {"keep_radius", "protect, preserve, whole, uncut"},
    {"keep_box", "protect, preserve, whole, uncut"},
};
constexpr GroupedParameter kHits[] = {
    {"local_point", "hit, hole, bullet hole, impact, chip"},
    {"local_radius", "hit radius, size of the hit, size of the hole"},
    {"local_sites", "fineness, pieces of a hit, number of pieces of a hit"},
    {"local_rest", "outside the hit, rest of the mesh"},
    {"of", "earlier answer, previous result"},
    {"delta", "changes, difference, incremental"},
    {"local_new", "new hits"},
};
constexpr GroupedParameter kAgain[] = {
    {"fragment", "refracture, break again, subdivide, secondary"},
    {"fragment_sites", "refracture, break again, pieces of a piece"},
    {"fragment_seed", "refracture, break again"},
};
constexpr GroupedParameter kAnchors[] = {
    {"anchor_plane", "pin, fix, ground, floor, support"},
    {"anchor_box", "pin, fix, support"},
    {"anchor_points", "pin, fix, support"},
    {"gravity", "down, fall"},
    {"broken", "destroyed, removed, missing pieces"},
};
constexpr GroupedParameter kOutside[] = {
    {"exterior", "outside, surface, skin, shading"},
};
constexpr GroupedParameter kInside[] = {
    {"interior", "inside, cut faces, cut surface"},
    {"interior_color", "inside colour, inside color, cut colour, cut color"},
    {"interior_mix", "blend, inside colour"},
    {"interior_shade", "darken, brightness"},
    {"interior_opacity", "transparency, transparent, alpha, translucent"},
    {"interior_crushed", "white crumbs, crushed ice, frost"},
    {"interior_roughness", "gloss, shiny, matt, pbr"},
    {"interior_metallic", "metalness, pbr"},
    {"interior_material", "inside material, cut material"},
    {"interior_name", "material name, slot name"},
    {"interior_detail", "normal map, relief, bump"},
    {"interior_uv_scale", "texture scale, tiling, uv"},
    {"interior_uv_u", "texture offset, uv"},
    {"interior_uv_v", "texture offset, uv"},
};
constexpr GroupedParameter kPhysics[] = {
    {"physics", "rigid bodies, colliders, godot, unity, engine"},
    {"ue_collision", "unreal, ucx, colliders"},
    {"max_hulls", "colliders, convex hulls, convex decomposition"},
    {"hull_excess", "colliders, convex decomposition, openings"},
    {"intact", "unbroken mesh, original"},
    {"pivot", "origin"},
    {"density", "weight, heavy"},
    {"mass", "weight, kilograms, heavy"},
    {"friction", "slide, slippery"},
    {"restitution", "bounce, bounciness, elasticity"},
    {"bond_strength", "glue, toughness, strength, break force"},
    {"contact_strength", "glue, strength between parts"},
};
constexpr GroupedParameter kBarycentric[] = {
    {"dual", "barycentre, barycenter, soft cells"},
    {"drop_above", "leave out large pieces"},
};

constexpr ParameterGroup kGroups[] = {
    {"The mesh", "", kMesh},
    {"Several materials", "See also [A house of several materials](guides/several-materials.md).", kSeveral},
    {"Cuts", "For pictures, see [Patterns and materials](materials.md).", kCuts},
    {"Ragged chunks", "Ragged chunks are fragments of several cells.", kChunks},
    {"Parameters of individual patterns", "", kPatterns},
    {"Rough cuts", "Noise makes the cut faces uneven; the two sides of a cut still match.", kRough},
    {"Number and size of fragments",
     "`report.size` shows the number of fragments and the distribution of volumes. Pieces broken off by hits do not count.",
     kSizes},
    {"Regions without cuts", "", kKept},
    {"Local hits",
     "A guide [compares local hits with `impacts`](guides/more-pieces-where-it-is-hit.md). "
     "See also [how a game uses local hits](interface.md#hit-the-fragments-again).",
     kHits},
    {"Break one fragment again", "", kAgain},
    {"Anchors and support",
     "`report.support` shows the load on each bond, weak bonds, and the fragments that fall.", kAnchors},
    {"Appearance of the outside", "", kOutside},
    {"Appearance of the cuts", "", kInside},
    {"Physics and engines", "", kPhysics},
    {"Barycentric cells", "The paper that this project started from defines these cells.", kBarycentric},
};

}  // namespace

std::span<const ParameterGroup> parameter_groups() { return kGroups; }

}  // namespace fracture
