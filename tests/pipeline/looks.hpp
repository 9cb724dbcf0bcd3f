// Measurements for the tests of appearance: sizes and cuts of a material's fragments, from the positions in
// the file.
#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "common/pipeline/fracture.hpp"
#include "common/solid/cut_materials.hpp"
#include "tests/support/pattern_requests.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {

inline FracturedSolid fractured(const Solid& solid, const FractureParameters& p) {
  StageTimings timings;
  const Expected<Diagram> diagram = make_diagram(solid, p, {}, timings);
  if (!diagram) throw std::runtime_error(diagram.error().detail);
  Expected<FracturedSolid> made = fracture(solid, *diagram, p, {}, timings);
  if (!made) throw std::runtime_error(made.error().detail);
  return std::move(*made);
}

inline FracturedSolid fractured(const Mesh& mesh, const FractureParameters& p) {
  return fractured(solid_of(mesh), p);
}

inline FractureParameters material(const char* name, std::uint32_t sites, std::uint64_t seed = 1) {
  return of_material(*find_material_preset(name), sites, seed);
}

inline Vec3d world(const Fragment& f, std::uint32_t v) { return to_double(f.positions[v]) + f.pivot; }

/// Calls visit(a, b, c) with the corners of each triangle of the cuts.
template <class Visit>
void for_each_cut(const FragmentSet& set, const Visit& visit) {
  for (const Fragment& f : set.fragments)
    for (const FragmentPrimitive& p : f.primitives) {
      if (!is_of_cuts(p.material)) continue;
      for (std::uint32_t k = p.first_index; k < p.first_index + p.index_count; k += 3)
        visit(world(f, f.indices[k]), world(f, f.indices[k + 1]), world(f, f.indices[k + 2]));
    }
}

inline double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

inline std::vector<double> volumes(const FragmentSet& set) {
  std::vector<double> all;
  for (const Fragment& f : set.fragments) all.push_back(f.mass.volume);
  std::sort(all.begin(), all.end());
  return all;
}

inline double coefficient_of_variation(const FragmentSet& set) {
  const std::vector<double> all = volumes(set);
  double mean = 0, square = 0;
  for (const double v : all) mean += v / static_cast<double>(all.size());
  for (const double v : all) square += (v - mean) * (v - mean) / static_cast<double>(all.size());
  return std::sqrt(square) / mean;
}

/// The side lengths of the box around the fragment.
inline Vec3d extent_of(const Fragment& fragment) {
  Box bounds;
  for (std::uint32_t v = 0; v < fragment.positions.size(); ++v) bounds.add(world(fragment, v));
  return bounds.size();
}

/// The share of the total volume that the largest fragments have; `share_of_count` says how many these are.
inline double share_of_largest(const FragmentSet& set, double share_of_count) {
  const std::vector<double> all = volumes(set);
  const auto count = static_cast<std::size_t>(std::ceil(share_of_count * static_cast<double>(all.size())));
  double large = 0, sum = 0;
  for (std::size_t k = 0; k < all.size(); ++k) {
    sum += all[k];
    if (k + count >= all.size()) large += all[k];
  }
  return large / sum;
}

}  // namespace fracture::test
