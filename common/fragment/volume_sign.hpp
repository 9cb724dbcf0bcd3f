// Has a group of pieces a volume? Known without joining its faces wherever the answer does not hang on
// rounding.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/fragment/piece_groups.hpp"
#include "common/fragment/pieces.hpp"

namespace fracture {

/// Signs of the volumes that groups of pieces have in the file. The caps between the pieces of a group cancel
/// and fusing moves no face, so its volume before rounding is the sum of theirs; what rounding can change of
/// it is bounded by the area. Each piece is measured once.
class VolumeSigns {
 public:
  /// Both are borrowed.
  VolumeSigns(const RestrictedDiagram& diagram, const Pieces& pieces, const Execution& execution);

  /// Of the union of two groups, which becomes one of this name. Throws Interrupted.
  void unite(const PieceGroups& groups, std::uint32_t a, std::uint32_t b, std::uint32_t name);
  /// 1 or -1: so it is in the file, where unite() made the group. 0: not known.
  int of(std::uint32_t group) const;

 private:
  struct Measure {
    double volume = 0;  ///< m³, before rounding
    double error = 0;   ///< m³: by how much the one in the file differs at most
    bool known = false;
  };
  Measure& of_group(const PieceGroups& groups, std::uint32_t group);
  void add(const Piece& piece, Measure& to);

  const RestrictedDiagram& d_;
  const Pieces& pieces_;
  const Execution& execution_;
  Pacer pacer_;
  double off_;                     ///< m: how far a vertex lies from where it was before rounding, at most
  std::vector<Measure> measures_;  ///< per name
};

}  // namespace fracture
