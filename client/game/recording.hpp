// A game as a file of JSON lines: what the player did, at which step which answer took effect, and a hash of the
// world after every step. Whoever plays it again with a server of the same version gets the same bits, or the first
// step at which they differ.
//
//   {"format": "fracture-game-1", "rules": 3, "scene": …}  the first line: whatever the program needs to begin alike
//   {"step": 36, "throw": [[x, y, z], [vx, vy, vz]]}  before step 36 (counted from 0), as are the next six; "radius" and
//                                                     "density" where the ball is not the scene's
//   {"step": 40, "explode": [x, y, z], "impulse": 4e4, "radius": 6}  N·s, metres
//   {"step": 61, "adopt": 1}                          the answer to the first request
//   {"step": 70, "fail": 2}                           the second came to nothing
//   {"step": 71, "overrides": {…}}                    parameters from the panel
//   {"step": 2, "thing": 0, "mass": 0.4}              a thing has so many times the mass that it was taken for
//   {"step": 71, "eye": [x, y, z]}                    from where it is seen, when that decides which hit is asked for
//   {"step": 36, "hash": "90ab…"}                     after step 36
#pragma once

#include <cstdint>
#include <fstream>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/base/error.hpp"

namespace fracture::game {

struct RecordedEvent {
  enum class Kind { kThrow, kExplode, kAdopt, kFail, kOverrides, kMass, kEye };
  std::uint64_t step = 0;
  Kind kind = Kind::kThrow;
  std::uint64_t request = 0;        ///< kAdopt, kFail: from 1, in the order of asking
  glm::dvec3 from{0}, velocity{0};  ///< kThrow; kEye, kExplode: from
  double radius = 0, density = 0;   ///< kThrow: 0, the scene's ball; kExplode: radius
  double impulse = 0;               ///< kExplode
  std::size_t thing = 0;            ///< kMass …
  double factor = 1;                ///< … and this
  nlohmann::json overrides{};       ///< kOverrides
};

/// What equal events lead to: raised when the world or the game answers them with other bits.
inline constexpr int kRules = 6;

struct Recording {
  nlohmann::json header;
  std::vector<RecordedEvent> events;  ///< in the order in which they happened
  std::vector<std::uint64_t> hashes;  ///< of World::fingerprint(), for each step
  bool cut_off = false;               ///< the file ends within a line, which is left out: a full disk, say
};

/// The line of an event, and back: what is not an event throws nlohmann::json::exception.
nlohmann::json line_of(const RecordedEvent& event);
RecordedEvent event_of(const nlohmann::json& line);
/// The line of a hash, without its end.
std::string hash_line(std::uint64_t step, std::uint64_t fingerprint);
/// "90ab…" as a number. Throws std::invalid_argument where it is none.
std::uint64_t hash_of(const std::string& text);

/// kFileAccess, or kBadJson with the line that is no line of a recording, or the rules that are not kRules.
Expected<Recording> read_recording(const std::string& path);
/// kFileAccess where the file cannot be written, or not all of it.
Expected<void> write_recording(const std::string& path, const Recording& recording);

class Recorder {
 public:
  /// kFileAccess where it cannot be written.
  static Expected<Recorder> create(const std::string& path, const nlohmann::json& header);
  void add(const RecordedEvent& event);
  void add_hash(std::uint64_t step, std::uint64_t fingerprint);
  /// Whether all of it is in the file; false on a full disk, say.
  bool finish() { return static_cast<bool>(out_.flush()); }

 private:
  explicit Recorder(std::ofstream out) : out_(std::move(out)) {}
  std::ofstream out_;
};

}  // namespace fracture::game
