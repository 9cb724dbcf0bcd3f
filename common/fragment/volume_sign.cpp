#include "common/fragment/volume_sign.hpp"

#include <cmath>

namespace fracture {

// Constructed vertices are rounded to the lattice (half a step on each axis), input vertices to float in
// the fragment's frame (2^-24 of at most the extent, which is less). Four steps also cover the rounding
// errors before that, and the fused outer faces, which leave out vertices that lie on their sides.
VolumeSigns::VolumeSigns(const RestrictedDiagram& diagram, const Pieces& pieces, const Execution& execution)
    : d_(diagram),
      pieces_(pieces),
      execution_(execution),
      pacer_(execution),
      off_(4 * length(diagram.positions.lattice.step())),
      measures_(pieces.pieces.size()) {}

// If the vertices of a closed surface move by at most `off` at constant speed, the volume swept at each
// moment is at most `off` times the current area. A triangle's area grows by at most its perimeter times
// `off` plus 2 off². A sum of n terms, each off by a few roundings, is off by less than (n + 16) 2^-52
// times the sum of the terms' bounds.
void VolumeSigns::add(const Piece& piece, Measure& to) {
  const Vec3d origin = d_.point(piece.faces[0].v[0]);
  double six = 0, terms = 0, two_areas = 0, perimeter = 0;
  for (const Face& face : piece.faces) {
    pacer_.step();
    const Vec3d a = d_.point(face.v[0]) - origin, b = d_.point(face.v[1]) - origin,
                c = d_.point(face.v[2]) - origin;
    six += dot(a, cross(b, c));
    terms += length(a) * length(b) * length(c);
    two_areas += length(cross(b - a, c - a));
    perimeter += length(b - a) + length(c - b) + length(a - c);
  }
  const auto n = static_cast<double>(piece.faces.size());
  to.volume += six / 6;
  to.error += 1.001 * (off_ * (0.5 * two_areas + off_ * (perimeter + 2 * n * off_)) +
                       (n + 16) * 0x1.0p-52 * terms + 0x1.0p-50 * std::fabs(to.volume));
}

VolumeSigns::Measure& VolumeSigns::of_group(const PieceGroups& groups, std::uint32_t group) {
  Measure& measure = measures_[group];
  if (measure.known) return measure;
  for (const std::uint32_t member : groups.members(group, execution_)) add(pieces_.pieces[member], measure);
  measure.known = true;
  return measure;
}

void VolumeSigns::unite(const PieceGroups& groups, std::uint32_t a, std::uint32_t b, std::uint32_t name) {
  const Measure x = of_group(groups, a), y = of_group(groups, b);
  const double volume = x.volume + y.volume;
  measures_[name] = {volume, x.error + y.error + 0x1.0p-50 * std::fabs(volume), true};
}

int VolumeSigns::of(std::uint32_t group) const {
  const Measure& measure = measures_[group];
  if (!measure.known || std::fabs(measure.volume) <= measure.error) return 0;
  return measure.volume > 0 ? 1 : -1;
}

}  // namespace fracture
