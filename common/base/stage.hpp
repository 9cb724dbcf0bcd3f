// The stages of a fracture and their names.
#pragma once

#include <array>
#include <cstddef>

namespace fracture {

enum class Stage { kImport, kPrepare, kTetrahedralize, kClip, kEncode };

struct StageRow {
  Stage stage;
  const char* name;  ///< used in Server-Timing, jobs, reports of bake, and errors
  /// Percentage of a whole fracture that is done when the stage ends: roughly its share of the time for a
  /// mesh with 10k triangles and 100 sites. 100 is reserved for answers that are done and stored.
  int ends_at;
};

/// In the order in which they run.
inline constexpr std::array<StageRow, 5> kStages{{{Stage::kImport, "import", 15},
                                                  {Stage::kPrepare, "prepare", 35},
                                                  {Stage::kTetrahedralize, "tetrahedralize", 45},
                                                  {Stage::kClip, "clip", 90},
                                                  {Stage::kEncode, "encode", 99}}};

constexpr std::size_t index_of(Stage stage) { return static_cast<std::size_t>(stage); }
constexpr const char* name_of(Stage stage) { return kStages[index_of(stage)].name; }

}  // namespace fracture
