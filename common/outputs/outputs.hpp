// Answers in formats that every tool reads: OBJ with MTL, PLY and STL, of an answer (answer.hpp), piece by piece and the
// same bytes each time. They show geometry and looks: no physics, bonds, hulls, clusters or figures, which are in GLB alone.
//
// Frame and unit are the GLB's: metres, y up. Fragments lie where they were cut from the mesh; their positions are the
// floats of Object::position(), in decimal the fewest digits that read back as the same float, so that each fragment is
// closed and what two share has the same bits. Parts that were not fractured come behind the fragments.
//
// Bytes follow from the answer alone: who alters them raises kAlgorithmVersion, as for an answer.
#pragma once

#include <string>
#include <vector>

#include "common/outputs/answer.hpp"
#include "common/outputs/sink.hpp"

namespace fracture::outputs {

/// glTF's vertex colours are linear, those of other files are sRGB by custom. kKeep: the mesh came from such a file, whose
/// numbers were taken as they are, and are given back so.
enum class VertexColors { kToSrgb, kKeep };

/// All functions: false where the sink took no more.

/// An object `o` for each fragment, called as in the GLB, and faces v/vt/vn. In an object one `v` stands for all vertices of the GLB that are
/// one by its EXT_mesh_manifold (else: at the same position), and have one colour: faces that touch name the same `v`.
/// Colours: `v x y z r g b`. `materials`: file name of the MTL.
bool write_obj(const Answer& answer, const std::string& materials, VertexColors colors, const Sink& sink);

/// The materials that an OBJ names. Kd, d, Ns, Ke as everywhere, Pr and Pm (roughness, metallic) for those who know
/// them, but for what a texture says of both, which MTL has no word for; map_Kd, norm and map_Ke, with the scale and offset of their texture coordinates. `textures[k]`: file name of
/// image k.
bool write_mtl(const Answer& answer, const std::vector<std::string>& textures, const Sink& sink);
/// Images that it names, in ascending order.
std::vector<std::size_t> images_of_mtl(const Answer& answer);

/// Binary, little-endian. Vertices as in the GLB, each with what some object has: normals, s and t (v up), colours of
/// 8 bits; `fragment` of each vertex and face counts fragments from 0, -1: of no fragment. Comments give their names
/// and ids.
bool write_ply(const Answer& answer, VertexColors colors, const Sink& sink);

/// Binary, one solid of all triangles in the order of the fragments.
bool write_stl(const Answer& answer, const Sink& sink);

/// Of a linear component in [0, 1] (IEC 61966-2-1).
double to_srgb(double linear);

}  // namespace fracture::outputs
