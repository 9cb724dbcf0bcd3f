#include "common/pipeline/instanced_bodies.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/clip/positions.hpp"
#include "common/pipeline/fracture_steps.hpp"
#include "common/pipeline/kept_instances.hpp"
#include "common/pipeline/part_sets.hpp"
#include "common/solid/patch.hpp"

namespace fracture {
namespace {

/// Relative difference between two sums over the same triangles, which cancel far from the origin. A part without cuts is whole,
/// unless a cavity was lost.
constexpr double kSameVolume = 1e-3;

/// Index of the instance that the fragment consists of; kNoIndex if it is none.
std::uint32_t instance_of(const Fragment& f, const Instances& instances) {
  if (!f.caps.empty() || f.positions.empty()) return kNoIndex;
  const std::uint32_t index = instances.of_part[f.part];
  if (index == kNoIndex) return kNoIndex;
  const Instance& instance = instances.all[index];
  std::size_t found = 0;
  if (f.part_cells.empty()) {
    found = instance.parts[0] == f.part ? 1 : 0;
  } else {
    for (std::size_t k = 0; k < f.part_cells.size(); ++k) {
      const std::uint32_t part = f.part_cells[k].part;
      if (k > 0 && part == f.part_cells[k - 1].part) continue;
      if (found == instance.parts.size() || instance.parts[found] != part) return kNoIndex;
      ++found;
    }
  }
  const bool whole = std::fabs(f.mass.volume - instance.volume) <= kSameVolume * instance.volume;
  return found == instance.parts.size() && whole ? index : kNoIndex;
}

/// The models of some shapes as a separate solid.
struct Models {
  SolidPatch patch;
  std::vector<std::uint32_t> shape;  ///< per instance of the patch
};

Models models_of(const Solid& solid, const std::vector<char>& wanted, const Execution& execution) {
  const Instances& instances = *solid.instances;
  std::vector<char> chosen(solid.parts.size(), 0);
  for (std::size_t s = 0; s < wanted.size(); ++s)
    if (wanted[s])
      for (const std::uint32_t p : instances.all[instances.models[s]].parts) chosen[p] = 1;
  std::vector<std::uint32_t> triangles;
  Pacer pacer(execution);
  pacer.each(0, solid.triangles.size(), [&](std::size_t t) {
    if (chosen[solid.part[t]]) triangles.push_back(static_cast<std::uint32_t>(t));
  });
  Models models{patch_of(solid, std::move(triangles), {}, execution), {}};
  Solid& patch = models.patch.solid;
  Instances found;
  found.of_part.assign(patch.parts.size(), kNoIndex);
  for (std::size_t s = 0; s < wanted.size(); ++s) {
    if (!wanted[s]) continue;
    Instance model = instances.all[instances.models[s]];
    for (std::uint32_t& p : model.parts) {
      p = models.patch.local_part(p);
      found.of_part[p] = static_cast<std::uint32_t>(found.all.size());
    }
    patch.report.volume += model.volume;
    found.all.push_back(std::move(model));
    models.shape.push_back(static_cast<std::uint32_t>(s));
  }
  patch.instances = std::make_shared<const Instances>(std::move(found));
  return models;
}

/// Gives parts other numbers. `number(part)` returns the new one.
template <class Number>
void renumber_parts(Fragment& f, const Number& number) {
  f.part = f.source_part = number(f.part);
  for (PartCell& cell : f.part_cells) cell.part = number(cell.part);
  for (PartVolume& volume : f.part_volumes) volume.part = number(volume.part);
  for (FragmentPrimitive& p : f.primitives)
    if (p.part != kNoIndex) p.part = number(p.part);
}

/// Numbers the shapes of instances. Parts that different entries of FractureParameters::assigned decide have their own looks, so
/// each entry has its own shapes. An instance that stays whole is decided by one entry.
class ShapeNumbers {
 public:
  ShapeNumbers(const Solid& solid, const FractureParameters& parameters, const Execution& execution)
      : count_(static_cast<std::uint32_t>(parameters.assigned.size()) + 1) {
    if (count_ > 1) entry_of_part_ = choose_assigned(solid, parameters, execution).of_part;
  }
  std::uint32_t of(const Instance& instance) const {
    const std::uint32_t entry = entry_of_part_.empty() ? kNoIndex : entry_of_part_[instance.parts[0]];
    return instance.shape * count_ + (entry == kNoIndex ? 0 : entry + 1);
  }

 private:
  std::uint32_t count_;
  std::vector<std::uint32_t> entry_of_part_;
};

/// Appends a shape with the parts of an instance other than its model, and so with the look of that instance.
void add_shape_of(const Instance& instance, const Instance& model, std::uint32_t shape_of_model,
                  std::uint32_t number, InstancedBodies& out) {
  Fragment shape = out.shapes[shape_of_model];
  renumber_parts(shape, [&](std::uint32_t part) {
    const auto at = std::lower_bound(model.parts.begin(), model.parts.end(), part);
    return instance.parts[static_cast<std::size_t>(at - model.parts.begin())];
  });
  out.shapes.push_back(std::move(shape));
  out.numbers.push_back(number);
  if (out.hulls.empty()) return;
  FragmentHulls hulls = out.hulls[shape_of_model];
  out.hulls.push_back(std::move(hulls));
}

/// Makes the wanted shapes as the fragments that a single cell makes of their models. Returns, per shape of the solid, its index
/// in `out`.
Expected<std::vector<std::uint32_t>> make_shapes(const Solid& solid, const std::vector<char>& wanted,
                                                 const FractureParameters& parameters,
                                                 const ShapeNumbers& numbers, InstancedBodies& out,
                                                 const Execution& execution) {
  std::vector<std::uint32_t> made(wanted.size(), kNoIndex);
  const Models models = models_of(solid, wanted, execution);
  FractureParameters whole;
  whole.pattern = PointsPattern{{solid.box.center()}};
  whole.sites = 1;
  whole.hulls = parameters.hulls;
  whole.hull_limits = parameters.hull_limits;
  whole.contact_strength = 0;
  Execution within = execution;
  within.progress = {};  // only the computation of the fragments reports progress
  within.within = nullptr;
  StageTimings timings;
  Expected<Diagram> diagram = make_diagram(models.patch.solid, whole, within, timings);
  if (!diagram) return tl::unexpected(std::move(diagram.error()));
  Expected<CutCells> cut = cut_cells(models.patch.solid, *diagram, whole, within);
  if (!cut) return tl::unexpected(std::move(cut.error()));
  CollisionHulls hulls;
  if (parameters.hulls == Hulls::kConvex)
    hulls = make_collision_hulls(cut->set, std::move(cut->hulls), parameters.hull_limits, execution);
  for (std::size_t k = 0; k < cut->set.fragments.size(); ++k) {
    Fragment& f = cut->set.fragments[k];
    const std::uint32_t model = instance_of(f, *models.patch.solid.instances);
    if (model == kNoIndex) continue;
    made[models.shape[model]] = static_cast<std::uint32_t>(out.shapes.size());
    renumber_parts(f, [&](std::uint32_t part) { return models.patch.parts[part]; });
    out.shapes.push_back(std::move(f));
    const Instances& instances = *solid.instances;
    out.numbers.push_back(numbers.of(instances.all[instances.models[models.shape[model]]]));
    if (!hulls.of_fragment.empty()) out.hulls.push_back(std::move(hulls.of_fragment[k]));
  }
  return made;
}

/// Places a shape where the instance is. The translation is rounded to the lattice, as the pivots of all fragments.
InstancedBodies::Body body_of(const Instance& instance, std::uint32_t index, const Fragment& shape,
                              const SeamLattice& lattice) {
  InstancedBodies::Body body;
  body.shape = index;
  // Copies that are only moved should have no rotation, whatever rounding left.
  constexpr double kNothing = 0x1p-30;
  for (std::size_t k = 0; k < 4; ++k) {
    const double component = instance.from_model.rotation[k];
    body.rotation[k] = std::fabs(component) < kNothing ? 0 : static_cast<float>(component);
  }
  body.scale = static_cast<float>(instance.from_model.scale);
  const Vec3d at = instance.from_model.point(shape.pivot), step = lattice.step();
  std::array<std::int32_t, 3> steps;
  for (int a = 0; a < 3; ++a)
    steps[static_cast<std::size_t>(a)] = static_cast<std::int32_t>(std::nearbyint(at[a] / step[a]));
  body.translation = lattice.to_world(steps);
  return body;
}

CollisionHull placed(const CollisionHull& hull, const Similarity& place, const Vec3d& pivot) {
  CollisionHull out = hull;
  for (Vec3f& p : out.points) {
    const Vec3d q = place.point(to_double(p)) - pivot;
    p = {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z)};
  }
  return out;
}

}  // namespace

Expected<InstancedBodies> find_instanced_bodies(const std::vector<Fragment>& fragments, const Solid& solid,
                                                const FractureParameters& parameters,
                                                const Execution& execution) {
  InstancedBodies out;
  if (!may_keep_instances(solid, parameters) || parameters.pivot != Pivot::kCenterOfMass ||
      is_barycentric(parameters))
    return out;
  const Instances& instances = *solid.instances;
  Pacer pacer(execution);
  std::vector<std::uint32_t> instance(fragments.size());
  std::vector<char> wanted(instances.models.size(), 0);
  bool any = false;
  for (std::size_t k = 0; k < fragments.size(); ++k) {
    pacer.step(4);
    instance[k] = instance_of(fragments[k], instances);
    if (instance[k] == kNoIndex) continue;
    wanted[instances.all[instance[k]].shape] = 1;
    any = true;
  }
  if (!any) return out;
  const ShapeNumbers numbers(solid, parameters, execution);
  const Expected<std::vector<std::uint32_t>> made =
      make_shapes(solid, wanted, parameters, numbers, out, execution);
  if (!made) return tl::unexpected(made.error());
  std::map<std::uint32_t, std::uint32_t> with_number;  // index of the shape
  for (std::uint32_t s = 0; s < out.numbers.size(); ++s) with_number.emplace(out.numbers[s], s);
  const SeamLattice lattice(solid.box);
  out.of_fragment.assign(fragments.size(), kNoIndex);
  for (std::size_t k = 0; k < fragments.size(); ++k) {
    pacer.step(16);
    if (instance[k] == kNoIndex) continue;
    const Instance& here = instances.all[instance[k]];
    const std::uint32_t of_model = (*made)[here.shape];
    if (of_model == kNoIndex) continue;
    const std::uint32_t number = numbers.of(here);
    const auto [at, fresh] = with_number.try_emplace(number, static_cast<std::uint32_t>(out.shapes.size()));
    if (fresh) add_shape_of(here, instances.all[instances.models[here.shape]], of_model, number, out);
    const std::uint32_t shape = at->second;
    out.of_fragment[k] = static_cast<std::uint32_t>(out.bodies.size());
    out.bodies.push_back(body_of(here, shape, out.shapes[shape], lattice));
  }
  return out;
}

void share_hulls(const InstancedBodies& instances, const std::vector<Fragment>& fragments,
                 CollisionHulls& hulls, const Execution& execution) {
  if (instances.hulls.empty()) return;
  hulls.of_fragment.resize(fragments.size());
  Pacer pacer(execution);
  for (std::size_t k = 0; k < fragments.size(); ++k) {
    const InstancedBodies::Body* const body = instances.of(k);
    if (body == nullptr || hulls.of_fragment[k].shared) continue;
    const Similarity place = body->place();
    FragmentHulls& here = hulls.of_fragment[k];
    here = instances.hulls[body->shape];
    here.volume *= place.scale * place.scale * place.scale;
    here.shared = true;
    for (CollisionHull& hull : here.hulls) {
      pacer.step(4 * hull.points.size());
      hull = placed(hull, place, fragments[k].pivot);
    }
  }
}

void separate_trimmed(InstancedBodies& instances, const CollisionHulls& hulls) {
  for (std::size_t k = 0; k < instances.of_fragment.size(); ++k) {
    const std::span<const CollisionHull> here = hulls.of(k);
    if (std::any_of(here.begin(), here.end(), [](const CollisionHull& hull) { return hull.untrimmed > 0; }))
      instances.of_fragment[k] = kNoIndex;
  }
}

std::optional<InstanceFigures> count_instances(const InstancedBodies& instances,
                                               const std::vector<std::uint32_t>& of_fragment) {
  InstanceFigures figures;
  std::vector<char> used(instances.shapes.size(), 0);
  for (const std::uint32_t body : of_fragment) {
    if (body == kNoIndex) continue;
    ++figures.fragments;
    used[instances.bodies[body].shape] = 1;
  }
  if (figures.fragments == 0) return std::nullopt;
  figures.shapes = static_cast<std::uint64_t>(std::count(used.begin(), used.end(), 1));
  return figures;
}

void separate_carriers(InstancedBodies& instances, const std::vector<Fragment>& fragments) {
  for (std::size_t k = 0; k < instances.of_fragment.size(); ++k)
    if (fragments[k].sheet) instances.of_fragment[k] = kNoIndex;
}

}  // namespace fracture
