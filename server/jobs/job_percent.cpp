#include "server/jobs/job_percent.hpp"

#include <algorithm>

namespace fracture {
namespace {

/// Duration of the clip stage and the following stages, in multiples of a relaxation pass.
constexpr double kClipOverPass = 1.5;

int ends(Stage stage) { return kStages[index_of(stage)].ends_at; }

}  // namespace

int clip_begins(std::uint32_t passes) {
  const int prepared = ends(Stage::kPrepare), clipped = ends(Stage::kClip);
  const double relaxed = prepared + (clipped - prepared) * passes / (passes + kClipOverPass);
  return std::max(ends(Stage::kTetrahedralize), static_cast<int>(relaxed));
}

int percent_of(Stage stage, double fraction, int clip_begins) {
  int begin = 1, end = ends(stage);
  if (stage != Stage::kImport) begin = kStages[index_of(stage) - 1].ends_at;
  if (stage == Stage::kTetrahedralize) end = clip_begins;
  if (stage == Stage::kClip) begin = clip_begins;
  return begin + static_cast<int>((end - begin) * std::clamp(fraction, 0.0, 1.0));
}

}  // namespace fracture
