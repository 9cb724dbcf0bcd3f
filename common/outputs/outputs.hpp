// Writes answers (answer.hpp) in formats that every tool reads: OBJ with MTL, PLY and STL. The output is
// written piece by piece, and its bytes are the same each time. It contains geometry and appearance. Only GLB
// has physics, bonds, hulls, clusters and statistics.
//
// Frame and unit are those of the GLB's root node: metres, y up. Positions do not contain the translation of the
// root, because floats are too coarse at that distance from the origin. OBJ and PLY state it in a comment
// ("offset (x, y, z)"). STL states it in its header if the 80 bytes suffice. Fragments keep their places in the mesh.
// Their positions are the floats of Object::position(). Decimal formats use the fewest digits that read back as
// the same float. So each fragment is closed, and points that two fragments share have the same bits. The sheets
// that a fragment carries follow it. Parts that were not fractured come after the fragments.
//
// The bytes depend only on the answer. A change that alters them must raise kAlgorithmVersion, as for
// answers.
#pragma once

#include <string>
#include <vector>

#include "common/outputs/answer.hpp"
#include "common/outputs/sink.hpp"

namespace fracture::outputs {

/// Vertex colours are linear in glTF, and by convention sRGB in other files. kKeep: the mesh came from such a
/// file, whose numbers were read unchanged, and are written unchanged.
enum class VertexColors { kToSrgb, kKeep };

/// All functions return false if the sink stopped accepting data.

/// Writes an object `o` for each fragment, named as in the GLB, and faces v/vt/vn. Within an object, one `v`
/// represents all vertices of the GLB that its EXT_mesh_manifold merges (without it: that have the same
/// position) and that have the same colour. So adjacent faces use the same `v`. Colours: `v x y z r g b`.
/// `materials`: file name of the MTL.
bool write_obj(const Answer& answer, const std::string& materials, VertexColors colors, const Sink& sink);

/// Writes the materials that an OBJ refers to: Kd, d, Ns and Ke as usual, and Pr and Pm (roughness, metallic)
/// for programs that support them. Pr and Pm are left out if a texture defines both, which MTL cannot
/// express. Textures: map_Kd, norm and map_Ke, with the scale and offset of their texture coordinates.
/// `textures[k]`: file name of image k.
bool write_mtl(const Answer& answer, const std::vector<std::string>& textures, const Sink& sink);
/// The images that the MTL refers to, in ascending order.
std::vector<std::size_t> images_of_mtl(const Answer& answer);

/// Writes binary, little-endian PLY. Vertices are those of the GLB, with every attribute that some object
/// has: normals, s and t (v up), colours with 8 bits. `fragment` of each vertex and face is the number of its
/// fragment from 0, also for its sheets; -1: not in a fragment. Comments contain the fragments' names and ids.
bool write_ply(const Answer& answer, VertexColors colors, const Sink& sink);

/// Writes binary STL: one solid with all triangles, in the order of the fragments.
bool write_stl(const Answer& answer, const Sink& sink);

/// Converts a linear component in [0, 1] to sRGB (IEC 61966-2-1).
double to_srgb(double linear);

}  // namespace fracture::outputs
