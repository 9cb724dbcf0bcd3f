// The report of an answer: the request, the result, and everything that a user should know about the difference.
// It contains only data; gltf/report_text.hpp writes it as text.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/base/choice.hpp"
#include "common/base/remarks.hpp"
#include "common/contacts/contact_report.hpp"
#include "common/fragment/size_limits.hpp"
#include "common/mesh/frame.hpp"
#include "common/physics/collision_hulls.hpp"
#include "common/pipeline/split_large.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

struct SiteFigures {
  std::uint64_t given = 0, used = 0;
  std::uint64_t duplicates_merged = 0;
  std::uint64_t far_dropped = 0;  ///< sites whose cells cannot reach the solid
  bool operator==(const SiteFigures&) const = default;
};

/// How the volumes of the fragments are distributed, m³.
struct VolumeDistribution {
  double smallest = 0, lowest_tenth = 0, median = 0, highest_tenth = 0, largest = 0;
  double mean = 0;
  double coefficient_of_variation = 0;  ///< standard deviation over the mean; 0: all are equal
  double share_of_largest_tenth = 0;    ///< of the total volume
  bool operator==(const VolumeDistribution&) const = default;
};

/// The requested sizes, and the sizes of the fragments made.
struct SizeReport {
  VolumeDistribution volumes;
  std::uint64_t triangles = 0;  ///< of all fragments
  SizeLimits limits;            ///< as requested
  SizeFigures united;           ///< effect of `limits`
  double max_volume = 0;        ///< m³, as requested; 0: no limit
  SplitFigures split;           ///< effect of `max_volume`
  bool operator==(const SizeReport&) const = default;
};

struct RoughCuts {
  double amplitude = 0;        ///< m, as used; 0: the cuts are flat
  double amplitude_asked = 0;  ///< m
  double edge_length = 0;      ///< m, to which the caps were refined
  std::uint64_t triangles = 0, calmed_vertices = 0, crossing_triangles = 0;
  std::uint32_t restrained_cells = 0;  ///< cells less rough than requested, or flat
  bool operator==(const RoughCuts&) const = default;
};

struct BarycenterReport {
  std::uint32_t skipped_hulls = 0;  ///< cells whose hull was flat
  /// The fragments that the volume filter left out, if one was requested.
  struct Dropped {
    std::uint32_t fragments = 0;
    double volume = 0;  ///< m³
    bool operator==(const Dropped&) const = default;
  };
  std::optional<Dropped> dropped{};
  bool operator==(const BarycenterReport&) const = default;
};

/// The fragments that are whole instances of a mesh (InstancedBodies).
struct InstanceFigures {
  std::uint64_t fragments = 0;
  std::uint64_t shapes = 0;  ///< that they share
  bool operator==(const InstanceFigures&) const = default;
};

/// The fragment that was fractured again.
struct RefracturedFragment {
  std::uint64_t id = 0;
  double volume = 0;  ///< m³
  bool operator==(const RefracturedFragment&) const = default;
};

/// Empty members were not requested.
struct Report {
  SolidReport solid;
  SiteFigures sites;
  SizeReport size;
  std::optional<ContactReport> contacts{};  ///< if the solid has several parts
  /// Effect of FractureParameters::keep.
  struct Kept {
    std::uint64_t cells = 0;  ///< cells that stay together
    double share = 0;         ///< of the solid's volume: fragments that meet the inside of the region
    bool operator==(const Kept&) const = default;
  };
  std::optional<Kept> kept{};
  std::optional<std::uint32_t> anchored{};     ///< number of anchored fragments
  std::optional<HullReport> hulls{};           ///< of all fragments of the answer
  std::optional<InstanceFigures> instances{};  ///< of the whole answer; empty: there are none
  std::optional<RoughCuts> rough_cuts{};
  std::optional<BarycenterReport> barycenter{};  ///< Dual::kBarycenter: no partition is promised
  std::optional<RefracturedFragment> fragment{};
  /// Set by the reader of the file: its frame, and the number of triangles excluded from fracturing.
  std::optional<FrameReport> frame{};
  std::optional<std::uint64_t> passed_through{};
  std::vector<Choice> choices{};  ///< of the solid, and those that the caller adds
  Remarks remarks;
  std::vector<Dropped> dropped{};  ///< of the source (Mesh::dropped)
  bool operator==(const Report&) const = default;
};

}  // namespace fracture
