// A game so far, in memory: what saves it to a file, and what goes back in it.
//
// Going back is playing again: until(step) is a recording that ends there, and a new Game plays it (GameSettings::replay)
// with the answers that were kept (KeptAnswers), so that no server is needed. States of the world are not kept instead:
// what Bullet knows of its contacts, the sleep of bodies and what hits have left behind are no part of what could be
// copied, and the first step after a copy would have other bits. What is played again has all of that, and says so by its
// hashes.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "client/game/decoder.hpp"
#include "client/game/recording.hpp"

namespace fracture::game {

/// In steps of 1/120 s at about 1 KB a second, some hours of play.
inline constexpr std::size_t kMostHistoryBytes = std::size_t{32} << 20;
inline constexpr std::size_t kMostKeptBytes = std::size_t{256} << 20;

class History {
 public:
  /// `most_bytes`: from there on nothing is kept any more; what was kept before stays.
  explicit History(nlohmann::json header, std::size_t most_bytes = kMostHistoryBytes);
  void add(RecordedEvent event);
  void add_hash(std::uint64_t fingerprint);

  bool full() const { return full_; }
  /// So many steps of the game are kept.
  std::uint64_t steps() const { return recording_.hashes.size(); }
  /// The first steps; all of them where there are fewer.
  Recording until(std::uint64_t steps) const;

 private:
  bool has_room(std::size_t bytes);
  Recording recording_;
  std::size_t bytes_ = 0;
  const std::size_t most_bytes_;
  bool full_ = false;
};

/// Answers by what was asked: equal requests have equal answers, so that a game that is played again needs none. A cache:
/// whatever is not in it is asked for. For one thread at a time.
class KeptAnswers {
 public:
  explicit KeptAnswers(std::size_t most_bytes = kMostKeptBytes) : most_bytes_(most_bytes) {}
  struct Kept {
    std::shared_ptr<const Decoded> answer;
    std::shared_ptr<const Decoded> before;  ///< of a further hit: what it is a change of
  };
  /// Null where it is not kept, or is a change of something else.
  std::shared_ptr<const Decoded> find(const std::string& mesh, const nlohmann::json& parameters,
                                      const std::shared_ptr<const Decoded>& before = nullptr) const;
  /// Not where all of them would be larger than `most_bytes` (of GLB).
  void keep(const std::string& mesh, const nlohmann::json& parameters, Kept answer);

 private:
  std::map<std::string, Kept> answers_;
  std::size_t bytes_ = 0;
  const std::size_t most_bytes_;
};

}  // namespace fracture::game
