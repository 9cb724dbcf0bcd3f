// The game so far, in memory, for saving it to a file and for going back.
//
// Going back replays the game: until(step) returns a recording that ends there, and a new Game plays it
// (GameSettings::replay) with the kept answers (KeptAnswers), so it needs no server. Saved states of the
// world would not be enough: Bullet's contact data, sleeping bodies and the effects of earlier hits cannot be
// copied, so the first step after a copy would give other bits. A replay reproduces all of them, and its
// hashes prove it.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "client/game/decoder.hpp"
#include "client/game/recording.hpp"

namespace fracture::game {

/// Some hours of play, at 120 steps per second and about 1 KB per second.
inline constexpr std::size_t kMostHistoryBytes = std::size_t{32} << 20;
inline constexpr std::size_t kMostKeptBytes = std::size_t{256} << 20;

class History {
 public:
  /// `most_bytes`: beyond this size, nothing more is recorded. Earlier events are kept.
  explicit History(nlohmann::json header, std::size_t most_bytes = kMostHistoryBytes);
  void add(RecordedEvent event);
  void add_hash(std::uint64_t fingerprint);

  bool full() const { return full_; }
  /// The number of recorded steps.
  std::uint64_t steps() const { return recording_.hashes.size(); }
  /// A recording of the first `steps` steps, or of all if there are fewer.
  Recording until(std::uint64_t steps) const;

 private:
  bool has_room(std::size_t bytes);
  Recording recording_;
  std::size_t bytes_ = 0;
  const std::size_t most_bytes_;
  bool full_ = false;
};

/// Answers by request. Equal requests have equal answers, so a replay needs none from the server. This is a
/// cache: an answer that is missing is requested. Not thread-safe.
class KeptAnswers {
 public:
  explicit KeptAnswers(std::size_t most_bytes = kMostKeptBytes) : most_bytes_(most_bytes) {}
  struct Kept {
    std::shared_ptr<const Decoded> answer;
    std::shared_ptr<const Decoded> before;  ///< for a further hit: the answer that it changes
  };
  /// Null if the answer is not kept, or if it changes another answer.
  std::shared_ptr<const Decoded> find(const std::string& mesh, const nlohmann::json& parameters,
                                      const std::shared_ptr<const Decoded>& before = nullptr) const;
  /// Keeps the answer, unless the total would exceed `most_bytes` (of GLB).
  void keep(const std::string& mesh, const nlohmann::json& parameters, Kept answer);

 private:
  std::map<std::string, Kept> answers_;
  std::size_t bytes_ = 0;
  const std::size_t most_bytes_;
};

}  // namespace fracture::game
