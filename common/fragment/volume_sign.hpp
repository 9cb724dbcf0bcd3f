// Signs of the volumes of groups of pieces, found without joining faces unless a sign depends on rounding.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/fragment/piece_groups.hpp"
#include "common/fragment/pieces.hpp"

namespace fracture {

/// Signs of the volumes that groups of pieces have in the file. The caps between the pieces of a group
/// cancel and fusing moves no face, so its volume before rounding is the sum of its pieces' volumes. The
/// area bounds how much rounding can change it. Each piece is measured once.
class VolumeSigns {
 public:
  /// Both are borrowed.
  VolumeSigns(const RestrictedDiagram& diagram, const Pieces& pieces, const Execution& execution);

  /// Computes the volume of the union of groups a and b, which has this name. Throws Interrupted.
  void unite(const PieceGroups& groups, std::uint32_t a, std::uint32_t b, std::uint32_t name);
  /// Returns the sign in the file, 1 or -1, of a group made by unite(); 0 if it is not known.
  int of(std::uint32_t group) const;

 private:
  struct Measure {
    double volume = 0;  ///< m³, before rounding
    double error = 0;   ///< m³: maximum difference to the volume in the file
    bool known = false;
  };
  Measure& of_group(const PieceGroups& groups, std::uint32_t group);
  void add(const Piece& piece, Measure& to);

  const RestrictedDiagram& d_;
  const Pieces& pieces_;
  const Execution& execution_;
  Pacer pacer_;
  double off_;                     ///< m: maximum distance by which rounding moves a vertex
  std::vector<Measure> measures_;  ///< per name
};

}  // namespace fracture
