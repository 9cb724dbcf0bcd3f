#include "client/sound/speakers.hpp"

#define AL_ALEXT_PROTOTYPES
#include <AL/al.h>
#include <AL/alc.h>
#include <AL/alext.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace fracture::sound {
namespace {

constexpr float kNear = 3;  // metres: a player's usual distance from a scene

template <class Call>
Call loopback_call(const char* name) {
  return reinterpret_cast<Call>(alcGetProcAddress(nullptr, name));
}

}  // namespace

struct Speakers::State {
  ALCdevice* device = nullptr;
  ALCcontext* context = nullptr;
  LPALCRENDERSAMPLESSOFT render = nullptr;
  std::array<ALuint, kVoices> sources{}, buffers{};
  std::array<double, kVoices> gains{};
  bool voices = false;

  ~State() {
    if (voices) {
      alDeleteSources(static_cast<ALsizei>(kVoices), sources.data());
      alDeleteBuffers(static_cast<ALsizei>(kVoices), buffers.data());
    }
    if (context != nullptr) {
      alcMakeContextCurrent(nullptr);
      alcDestroyContext(context);
    }
    if (device != nullptr) alcCloseDevice(device);
  }
};

Speakers::Speakers(std::unique_ptr<State> state) : state_(std::move(state)) {}
Speakers::Speakers(Speakers&&) noexcept = default;
Speakers::~Speakers() = default;

Expected<Speakers> Speakers::start(std::unique_ptr<State> state, const int* attributes) {
  if (state->device == nullptr) return fail(ErrorCode::kNoSound, "OpenAL cannot open a device.");
  state->context = alcCreateContext(state->device, attributes);
  if (state->context == nullptr || alcMakeContextCurrent(state->context) == ALC_FALSE)
    return fail(ErrorCode::kNoSound,
                "OpenAL cannot create a context (error " + std::to_string(alcGetError(state->device)) + ").");
  alGenSources(static_cast<ALsizei>(kVoices), state->sources.data());
  if (alGetError() != AL_NO_ERROR) return fail(ErrorCode::kNoSound, "OpenAL provides too few sources.");
  alGenBuffers(static_cast<ALsizei>(kVoices), state->buffers.data());
  state->voices = true;
  alDistanceModel(AL_INVERSE_DISTANCE_CLAMPED);
  for (const ALuint source : state->sources) {
    alSourcef(source, AL_REFERENCE_DISTANCE, kNear);
    alSourcef(source, AL_ROLLOFF_FACTOR, 1);
  }
  return Speakers(std::move(state));
}

Expected<Speakers> Speakers::device() {
  auto state = std::make_unique<State>();
  state->device = alcOpenDevice(nullptr);
  return start(std::move(state), nullptr);
}

Expected<Speakers> Speakers::loopback() {
  if (alcIsExtensionPresent(nullptr, "ALC_SOFT_loopback") == ALC_FALSE)
    return fail(ErrorCode::kNoSound, "This version of OpenAL does not support loopback (ALC_SOFT_loopback).");
  auto state = std::make_unique<State>();
  state->device = loopback_call<LPALCLOOPBACKOPENDEVICESOFT>("alcLoopbackOpenDeviceSOFT")(nullptr);
  state->render = loopback_call<LPALCRENDERSAMPLESSOFT>("alcRenderSamplesSOFT");
  // All attributes are set, because the user's OpenAL configuration must not change the result.
  constexpr int kAttributes[] = {ALC_FORMAT_CHANNELS_SOFT,
                                 ALC_STEREO_SOFT,
                                 ALC_FORMAT_TYPE_SOFT,
                                 ALC_FLOAT_SOFT,
                                 ALC_FREQUENCY,
                                 kRate,
                                 ALC_HRTF_SOFT,
                                 ALC_FALSE,
                                 ALC_OUTPUT_LIMITER_SOFT,
                                 ALC_FALSE,
                                 0};
  return start(std::move(state), kAttributes);
}

void Speakers::play(const Clip& clip, const glm::dvec3& where, double gain) {
  if (clip.samples.empty() || !(gain > 0)) return;
  State& s = *state_;
  std::size_t chosen = 0;
  double faintest = HUGE_VAL;
  for (std::size_t k = 0; k < kVoices; ++k) {
    ALint playing = 0;
    alGetSourcei(s.sources[k], AL_SOURCE_STATE, &playing);
    const double heard = playing == AL_PLAYING ? s.gains[k] : 0;
    if (heard >= faintest) continue;
    faintest = heard;
    chosen = k;
  }
  if (faintest >= gain) return;
  s.gains[chosen] = gain;
  std::vector<std::int16_t> samples;
  samples.reserve(clip.samples.size());
  for (const float x : clip.samples)
    samples.push_back(static_cast<std::int16_t>(std::lround(32767.f * std::clamp(x, -1.f, 1.f))));
  const ALuint source = s.sources[chosen], buffer = s.buffers[chosen];
  alSourceStop(source);
  alSourcei(source, AL_BUFFER, 0);
  alBufferData(buffer, AL_FORMAT_MONO16, samples.data(), static_cast<ALsizei>(2 * samples.size()), kRate);
  alSourcei(source, AL_BUFFER, static_cast<ALint>(buffer));
  alSourcef(source, AL_GAIN, static_cast<float>(std::min(gain, 1.0)));
  alSource3f(source, AL_POSITION, static_cast<float>(where.x), static_cast<float>(where.y),
             static_cast<float>(where.z));
  alSourcePlay(source);
}

void Speakers::listen(const glm::dvec3& eye, const glm::dvec3& forward) {
  alListener3f(AL_POSITION, static_cast<float>(eye.x), static_cast<float>(eye.y), static_cast<float>(eye.z));
  const float turned[6] = {
      static_cast<float>(forward.x), static_cast<float>(forward.y), static_cast<float>(forward.z), 0, 1, 0};
  alListenerfv(AL_ORIENTATION, turned);
}

void Speakers::set_volume(double volume) {
  alListenerf(AL_GAIN, static_cast<float>(std::clamp(volume, 0.0, 1.0)));
}

void Speakers::render(std::span<float> samples) {
  if (state_->render != nullptr)
    state_->render(state_->device, samples.data(), static_cast<ALCsizei>(samples.size() / 2));
}

}  // namespace fracture::sound
