#include "common/pipeline/given_colliders.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/base/printable.hpp"
#include "common/bvh/box_tree.hpp"
#include "common/physics/given_hulls.hpp"

namespace fracture {
namespace {

/// Finds the part that a given hull belongs to.
class PartFinder {
 public:
  PartFinder(const Solid& solid, const std::vector<Fragment>& parts, const Execution& execution)
      : parts_(parts), boxes_(boxes_of(solid, parts)), tree_(boxes_, execution) {
    for (std::uint32_t k = 0; k < parts.size(); ++k) first_part_.try_emplace(parts[k].node, k);
  }

  /// Empty if no part belongs to an owner.
  std::optional<std::uint32_t> part_of(const GivenHull& hull) {
    Box box;
    for (const Vec3f& p : hull.points) box.add(to_double(p));
    std::optional<std::uint32_t> best;
    double most = 0;
    tree_.each_overlapping(box, [&](std::uint32_t part) {
      if (!std::binary_search(hull.owners->begin(), hull.owners->end(), parts_[part].node)) return;
      const Vec3d size = common_of(box, boxes_[part]).size();
      const double volume = size.x * size.y * size.z;
      if (best && (volume < most || (volume == most && part > *best))) return;
      best = part;
      most = volume;
    });
    return best ? best : first_part_of(hull);
  }

 private:
  static std::vector<Box> boxes_of(const Solid& solid, const std::vector<Fragment>& parts) {
    std::vector<Box> boxes;
    for (const Fragment& part : parts) boxes.push_back(solid.parts[part.part].box);
    return boxes;
  }

  std::optional<std::uint32_t> first_part_of(const GivenHull& hull) {
    const auto [at, is_new] = first_of_owners_.try_emplace(hull.owners.get());
    if (is_new)
      for (const std::uint32_t node : *hull.owners)
        if (const auto part = first_part_.find(node); part != first_part_.end())
          at->second = std::min(at->second.value_or(part->second), part->second);
    return at->second;
  }

  const std::vector<Fragment>& parts_;
  const std::vector<Box> boxes_;
  const BoxTree tree_;
  std::map<std::uint32_t, std::uint32_t> first_part_;  ///< of each node
  /// Looked up, never iterated
  std::map<const std::vector<std::uint32_t>*, std::optional<std::uint32_t>> first_of_owners_;
};

}  // namespace

void use_given_hulls(const Solid& solid, double most_excess, IntactSolid& intact,
                     const Execution& execution) {
  const std::vector<GivenHull>& given = solid.source->given_hulls;
  if (given.empty()) return;
  Pacer pacer(execution);
  PartFinder finder(solid, intact.parts, execution);
  std::map<std::uint32_t, FragmentHulls> of_part;
  std::map<std::uint32_t, bool> has_given;  // nodes
  std::string unused;
  for (const GivenHull& hull : given) {
    pacer.step(64);
    const std::optional<std::uint32_t> part = finder.part_of(hull);
    if (!part) continue;
    FragmentHulls made = make_given_hulls(hull, most_excess, execution);
    if (made.hulls.empty()) {
      if (unused.empty()) unused = printable(shortened(hull.name));
      continue;
    }
    has_given[intact.parts[*part].node] = true;
    FragmentHulls& sum = of_part[*part];
    sum.simplified += made.simplified;
    sum.volume += made.volume;
    std::move(made.hulls.begin(), made.hulls.end(), std::back_inserter(sum.hulls));
  }
  for (std::uint32_t k = 0; k < intact.parts.size(); ++k) {
    pacer.step(8);
    if (!has_given.contains(intact.parts[k].node)) continue;
    FragmentHulls& hulls = intact.hulls.of_fragment[k];
    hulls = {};
    if (const auto at = of_part.find(k); at != of_part.end()) hulls = std::move(at->second);
    const double volume = intact.parts[k].mass.volume;
    hulls.excess = volume > 0 ? hulls.volume / volume : 0;
  }
  if (!unused.empty())
    intact.warnings.push_back("Collision geometry such as " + unused +
                              " is flat or not convex, so it is not used. The unbroken mesh has computed "
                              "hulls instead. To use this geometry, build it from convex pieces.");
}

}  // namespace fracture
