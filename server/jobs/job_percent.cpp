#include "server/jobs/job_percent.hpp"

#include <algorithm>

namespace fracture {
namespace {

/// Where the stages begin and end: roughly their shares of the time for a mesh of 10k triangles and 100
/// sites.
constexpr int kImport = 1, kPrepare = 15, kTetrahedralize = 35, kClip = 45, kEncode = 90, kEnd = 99;

/// What a pass takes of the time that clip and what follows take.
constexpr double kClipOverPass = 1.5;

}  // namespace

int clip_begins(std::uint32_t passes) {
  const double relaxed = kTetrahedralize + (kEncode - kTetrahedralize) * passes / (passes + kClipOverPass);
  return std::max(kClip, static_cast<int>(relaxed));
}

std::optional<int> percent_of(std::string_view stage, double fraction, int clip_begins) {
  const struct {
    std::string_view name;
    int begin, end;
  } stages[] = {{"import", kImport, kPrepare},
                {"prepare", kPrepare, kTetrahedralize},
                {"tetrahedralize", kTetrahedralize, clip_begins},
                {"clip", clip_begins, kEncode},
                {"encode", kEncode, kEnd}};
  for (const auto& [name, begin, end] : stages)
    if (name == stage) return begin + static_cast<int>((end - begin) * std::clamp(fraction, 0.0, 1.0));
  return std::nullopt;
}

}  // namespace fracture
