// The figures of one solid that estimates use again and again. An estimate is made for many parameters: the largest count that fits is
// searched for. So what depends only on the solid and on the place of a hit is computed once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/pacer.hpp"
#include "common/pipeline/local_impact.hpp"
#include "server/service/cell_means.hpp"

namespace fracture {

/// The sites of a hit are dense in the middle of its ball, so fewer of its cells meet earlier cuts. (Counted with random points: 0.6 to
/// 0.8.)
inline constexpr double kDenseInTheMiddle = 0.7;

/// The small parts that a hit reaches. The hit cuts each of them by itself.
struct SmallParts {
  double count = 0, volume = 0;
  double pieces = 0;     ///< of all of them together
  bool are_all = false;  ///< whether the hit reaches no larger part
};

/// Parts in contact with no other part, if they are much smaller than a cell. None of them becomes part of another fragment.
struct LooseParts {
  double count = 0;
  double pieces = 0;  ///< that random cells cut them into
};

/// Borrows the solid. For one thread, although it is const: each figure is computed when it is first asked for.
class SolidFigures {
 public:
  /// `execution`: polled in loops over parts and hits, which throw Interrupted. Borrowed.
  SolidFigures(const Solid& solid, const Execution& execution = kUninterrupted)
      : solid_(solid), pacer_(execution) {}
  SolidFigures(const SolidFigures&) = delete;
  SolidFigures& operator=(const SolidFigures&) = delete;

  const Solid& solid() const { return solid_; }
  const SolidShape& shape() const;
  /// `cell`: m³, the volume of a cell. `are_apart`: parts are loose although they are in contact. If contacts are not known, there are
  /// none. Linear in parts and contacts.
  LooseParts loose_parts(double cell, bool are_apart) const;
  /// `space`: m³, that the hit breaks if the solid fills it. Linear in the parts.
  SmallParts small_parts(const LocalImpact& hit, double space) const;

  /// Counts steps of about ten nanoseconds: polls, and reports them as bulk (base/bulk.hpp).
  void step(std::size_t steps) const;

 private:
  /// Calls visit(part, its number) for each part.
  template <class Visit>
  void each_part(const Visit& visit) const;
  /// By how much the sides of each part's box shrink (cell_means.hpp).
  const std::vector<double>& fills() const;

  const Solid& solid_;
  mutable Pacer pacer_;
  mutable std::optional<SolidShape> shape_{};
  mutable std::vector<double> fills_{};     ///< per part
  mutable std::vector<char> in_contact_{};  ///< per part
  mutable std::map<std::pair<double, bool>, LooseParts> loose_{};
  mutable std::map<std::array<double, 6>, SmallParts> small_{};  ///< by point, radius, sites and space
};

}  // namespace fracture
