// A game as a file of JSON lines: the player's actions, the step at which each answer took effect, and a hash of the
// world after every step. Replaying it with a server of the same version gives the same bits, or the first step at
// which they differ.
//
//   {"format": "fracture-game-1", "rules": 6, "scene": …}  the first line: everything needed for the same start.
//   {"step": 36, "throw": [[x, y, z], [vx, vy, vz]]}  before step 36 (counted from 0), like the next six. With "radius"
//                                                     and "density" if it is not the scene's ball.
//   {"step": 40, "explode": [x, y, z], "impulse": 4e4, "radius": 6}  N·s, metres
//   {"step": 61, "adopt": 1}                          the answer to the first request takes effect
//   {"step": 70, "fail": 2}                           the second request failed
//   {"step": 71, "overrides": {…}}                    parameters from the panel
//   {"step": 2, "thing": 0, "mass": 0.4}              the mass of a thing is this multiple of the assumed mass
//   {"step": 71, "eye": [x, y, z]}                    the player's viewpoint, if it decides which hit is requested first
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
  std::uint64_t request = 0;        ///< kAdopt, kFail: from 1, in request order
  glm::dvec3 from{0}, velocity{0};  ///< kThrow; kEye, kExplode: from
  double radius = 0, density = 0;   ///< kThrow: 0, the scene's ball; kExplode: radius
  double impulse = 0;               ///< kExplode
  std::size_t thing = 0;            ///< kMass …
  double factor = 1;                ///< … and this
  nlohmann::json overrides{};       ///< kOverrides
};

/// Version of the rules. Raised when the world or the game responds to the same events with different bits.
inline constexpr int kRules = 6;

struct Recording {
  nlohmann::json header;
  std::vector<RecordedEvent> events;  ///< in the order in which they happened
  std::vector<std::uint64_t> hashes;  ///< World::fingerprint() after each step
  bool cut_off = false;               ///< the file ends within a line (ignored), for example on a full disk
};

/// Converts an event to a line, and back. Throws nlohmann::json::exception if the line is not an event.
nlohmann::json line_of(const RecordedEvent& event);
RecordedEvent event_of(const nlohmann::json& line);
/// The line of a hash, without its line break.
std::string hash_line(std::uint64_t step, std::uint64_t fingerprint);
/// "90ab…" as a number. Throws std::invalid_argument if it is malformed.
std::uint64_t hash_of(const std::string& text);

/// Fails with kFileAccess, or with kBadJson if a line is invalid or the rules are not kRules.
Expected<Recording> read_recording(const std::string& path);
/// Fails with kFileAccess if the file cannot be written completely.
Expected<void> write_recording(const std::string& path, const Recording& recording);

class Recorder {
 public:
  /// Fails with kFileAccess if the file cannot be written.
  static Expected<Recorder> create(const std::string& path, const nlohmann::json& header);
  void add(const RecordedEvent& event);
  void add_hash(std::uint64_t step, std::uint64_t fingerprint);
  /// Whether everything is in the file; false on a full disk, for example.
  bool finish() { return static_cast<bool>(out_.flush()); }

 private:
  explicit Recorder(std::ofstream out) : out_(std::move(out)) {}
  std::ofstream out_;
};

}  // namespace fracture::game
