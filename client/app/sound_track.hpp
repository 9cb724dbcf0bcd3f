// What a game without a window sounds like, as a file.
#pragma once

#include "client/game/game.hpp"
#include "client/sound/soundscape.hpp"
#include "client/sound/speakers.hpp"
#include "client/sound/wav.hpp"

namespace fracture::app {

/// WorldSettings::max_witnessed of a game that is seen and heard: more in one frame is more than anybody can tell apart.
inline constexpr std::size_t kMostWitnessed = 1024;

/// By the game's objects.
inline sound::Soundscape::MaterialOf materials_of(const game::Game& game) {
  return [&game](world::ObjectId object) { return game.material_of(object); };
}

class SoundTrack {
 public:
  /// Heard from the scene's eye. kNoSound, kFileAccess.
  static Expected<SoundTrack> create(const std::string& path, const scenes::Scene& scene);
  /// After each step of the game, with what was witnessed in it.
  void add(const game::Game& game, const world::Witnessed& witnessed);
  /// kFileAccess where not all of it is in the file.
  Expected<void> finish();

 private:
  SoundTrack(std::string path, sound::WavFile file, sound::Speakers speakers)
      : path_(std::move(path)), file_(std::move(file)), speakers_(std::move(speakers)) {}
  std::string path_;
  sound::WavFile file_;
  sound::Speakers speakers_;
  sound::Soundscape soundscape_;
  double owed_ = 0;  ///< frames of sound that are not rendered yet, less than one
};

}  // namespace fracture::app
