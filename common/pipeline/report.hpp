// What an answer says of itself beside its fragments: what was asked, what was made, and everything that
// somebody should know about the difference. Figures alone; gltf/report_text.hpp gives them their names.
#pragma once

#include <cstdint>
#include <optional>

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
  std::uint64_t far_dropped = 0;  ///< whose cells cannot reach the solid
  bool operator==(const SiteFigures&) const = default;
};

/// How the volumes of the fragments are distributed, m³.
struct VolumeDistribution {
  double smallest = 0, lowest_tenth = 0, median = 0, highest_tenth = 0, largest = 0;
  double mean = 0;
  double coefficient_of_variation = 0;  ///< the standard deviation over the mean: 0 is all alike
  double share_of_largest_tenth = 0;    ///< of the volume of all
  bool operator==(const VolumeDistribution&) const = default;
};

/// The requested sizes, and the sizes of the fragments made.
struct SizeReport {
  VolumeDistribution volumes;
  std::uint64_t triangles = 0;  ///< of all fragments
  SizeLimits limits;            ///< as asked
  SizeFigures united;           ///< what they did
  double max_volume = 0;        ///< m³, as asked; 0: no limit
  SplitFigures split;           ///< what it did
  bool operator==(const SizeReport&) const = default;
};

struct RoughCuts {
  double amplitude = 0;        ///< m, in force; 0: the cuts are flat
  double amplitude_asked = 0;  ///< m
  double edge_length = 0;      ///< m, that the caps were refined to
  std::uint64_t triangles = 0, calmed_vertices = 0, crossing_triangles = 0;
  std::uint32_t restrained_cells = 0;  ///< less rough than asked, or flat
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

/// Which fragment was fractured again.
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
  std::optional<ContactReport> contacts{};    ///< if the solid has several parts
  std::optional<std::uint64_t> kept_cells{};  ///< that FractureParameters::keep keeps together
  std::optional<std::uint32_t> anchored{};    ///< how many fragments are
  std::optional<HullReport> hulls{};          ///< of all fragments of the answer
  std::optional<RoughCuts> rough_cuts{};
  std::optional<BarycenterReport> barycenter{};  ///< Dual::kBarycenter: no partition is promised
  std::optional<RefracturedFragment> fragment{};
  /// By who read the file: its frame, and the triangles that were not to be fractured.
  std::optional<FrameReport> frame{};
  std::optional<std::uint64_t> passed_through{};
  Remarks remarks;
  bool operator==(const Report&) const = default;
};

}  // namespace fracture
