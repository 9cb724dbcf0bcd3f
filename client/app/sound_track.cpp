#include "client/app/sound_track.hpp"

namespace fracture::app {

Expected<SoundTrack> SoundTrack::create(const std::string& path, const scenes::Scene& scene) {
  Expected<sound::Speakers> speakers = sound::Speakers::loopback();
  if (!speakers) return tl::unexpected(speakers.error());
  Expected<sound::WavFile> file = sound::WavFile::create(path);
  if (!file) return tl::unexpected(file.error());
  const glm::dvec3 eye(scene.eye), target(scene.target);
  speakers->listen(eye, glm::normalize(target - eye));
  return SoundTrack(path, std::move(*file), std::move(*speakers));
}

void SoundTrack::add(const game::Game& game, const world::Witnessed& witnessed) {
  for (const sound::Voice& voice : soundscape_.voices(witnessed, materials_of(game))) {
    const sound::Clip clip = sound::strike(voice.modes, voice.impulse, voice.contact);
    speakers_.play(clip, voice.where, sound::amplitude_of(clip.pressure));
  }
  owed_ += game.settings().world.step * sound::kRate;
  const auto frames = static_cast<std::size_t>(owed_ + 1e-6);
  owed_ -= static_cast<double>(frames);
  std::vector<float> samples(2 * frames);
  speakers_.render(samples);
  file_.add(samples);
}

Expected<void> SoundTrack::finish() {
  if (!file_.finish())
    return fail(ErrorCode::kFileAccess,
                "Cannot finish writing the sound file " + path_ + ". Is the disk full?");
  return {};
}

}  // namespace fracture::app
