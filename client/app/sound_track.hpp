// The sound of a game without a window, written to a file.
#pragma once

#include "client/game/game.hpp"
#include "client/sound/soundscape.hpp"
#include "client/sound/speakers.hpp"
#include "client/sound/wav.hpp"

namespace fracture::app {

/// WorldSettings::max_witnessed of a game with picture or sound. Nobody can distinguish more events in a
/// frame.
inline constexpr std::size_t kMostWitnessed = 1024;

/// Returns a function that looks up the material of the game's objects.
inline sound::Soundscape::MaterialOf materials_of(const game::Game& game) {
  return [&game](world::ObjectId object) { return game.material_of(object); };
}

class SoundTrack {
 public:
  /// The listener is at the scene's eye. kNoSound, kFileAccess.
  static Expected<SoundTrack> create(const std::string& path, const scenes::Scene& scene);
  /// Call after each step of the game, with the events witnessed in it.
  void add(const game::Game& game, const world::Witnessed& witnessed);
  /// kFileAccess if the file is incomplete.
  Expected<void> finish();

 private:
  SoundTrack(std::string path, sound::WavFile file, sound::Speakers speakers)
      : path_(std::move(path)), file_(std::move(file)), speakers_(std::move(speakers)) {}
  std::string path_;
  sound::WavFile file_;
  sound::Speakers speakers_;
  sound::Soundscape soundscape_;
  double owed_ = 0;  ///< fraction of a frame of sound that is not rendered yet
};

}  // namespace fracture::app
