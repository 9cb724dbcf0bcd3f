// Audible results: modes by material and size, loudness by distance, silence, files.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "client/sound/player.hpp"
#include "client/sound/speakers.hpp"
#include "client/sound/wav.hpp"
#include "tests/server/support/temporary_folder.hpp"

namespace fracture::sound {
namespace {

constexpr std::array kNames = {"stone", "glass",     "wood", "concrete", "brick",     "ceramic",
                               "metal", "cast_iron", "ice",  "plaster",  "sandstone", "terracotta"};
const glm::dvec3 kTile(0.3, 0.2, 0.02);  // metres

std::vector<Mode> tile_of(const char* material, double scale = 1) {
  const SoundMaterial& of = sound_material(material);
  const glm::dvec3 sides = scale * kTile;
  return modes_of(of, of.density * sides.x * sides.y * sides.z, sides, false, 1);
}

/// The frequency at which a sound has the most energy, by a discrete Fourier transform of half a second in
/// steps of 5 Hz.
double spectral_peak(const std::vector<float>& samples) {
  double best = 0, most = 0;
  const std::size_t count = std::min<std::size_t>(samples.size(), kRate / 2);
  for (double frequency = 50; frequency < 12000; frequency += 5) {
    const std::complex<double> turn = std::polar(1.0, 2 * std::numbers::pi * frequency / kRate);
    std::complex<double> sum = 0, at = 1;
    for (std::size_t k = 0; k < count; ++k) {
      sum += static_cast<double>(samples[k]) * at;
      at *= turn;
    }
    if (std::norm(sum) <= most) continue;
    most = std::norm(sum);
    best = frequency;
  }
  return best;
}

double loudness(const std::vector<float>& samples) {  // root mean square
  double sum = 0;
  for (const float x : samples) sum += static_cast<double>(x) * x;
  return std::sqrt(sum / static_cast<double>(samples.size()));
}

/// A tenth of a second of a tile that is struck at `where`, heard from the origin.
std::vector<float> heard(const glm::dvec3& where, double gain = 0.5) {
  Expected<Speakers> speakers = Speakers::loopback();
  if (!speakers) throw std::runtime_error(speakers.error().detail);
  speakers->listen({0, 0, 0}, {0, 0, -1});
  speakers->play(strike(tile_of("glass"), 1, 1e-4), where, gain);
  std::vector<float> samples(2 * kRate / 10);
  speakers->render(samples);
  return samples;
}

std::vector<float> channel(const std::vector<float>& samples, std::size_t which) {
  std::vector<float> one;
  for (std::size_t k = which; k < samples.size(); k += 2) one.push_back(samples[k]);
  return one;
}

TEST(Modes, AreThoseOfThePlateInTheLiterature) {
  // Thin enough for Kirchhoff: f11 = π/2 √(E h² / 12 ρ (1 − ν²)) (1/a² + 1/b²), computed by hand for steel, a
  // = b = 1 m, h = 1 mm: 1.5708 · 1.5414 m²/s · 2 = 4.843 Hz. The frequency of mode (m, n) is that times (m²
  // + n²) / 2.
  const SoundMaterial& steel = sound_material("metal");
  const auto modes = modes_of(steel, steel.density * 1e-3, {1, 1, 1e-3}, false, 3);
  ASSERT_GT(modes.size(), 3u);
  // The lowest audible mode (30 Hz and more) has m² + n² = 13.
  EXPECT_NEAR(modes.front().frequency, 4.843 * 13 / 2, 0.4);
  EXPECT_TRUE(std::is_sorted(modes.begin(), modes.end(),
                             [](const Mode& a, const Mode& b) { return a.frequency < b.frequency; }));
}

TEST(Modes, AHalfAsLargeBodyRingsAnOctaveHigher) {
  for (const char* name : kNames) {
    const auto large = tile_of(name), small = tile_of(name, 0.5);
    ASSERT_FALSE(large.empty() || small.empty()) << name;
    EXPECT_NEAR(small.front().frequency / large.front().frequency, 2, 1e-9) << name;
  }
}

TEST(Modes, WhatIsSmallerThanAnythingHeardHasNone) {
  EXPECT_TRUE(modes_of(sound_material("glass"), 1e-6, glm::dvec3(1e-4), false, 1).empty());
  EXPECT_TRUE(modes_of(sound_material("glass"), 0, glm::dvec3(1), false, 1).empty());
}

TEST(Modes, SidesOfABoxComeBackFromItsInertia) {
  const glm::dvec3 box(0.7, 0.4, 0.1);
  const double density = 2000, mass = density * box.x * box.y * box.z;
  const glm::dvec3 moments =
      mass / 12 *
      glm::dvec3(box.y * box.y + box.z * box.z, box.x * box.x + box.z * box.z, box.x * box.x + box.y * box.y);
  EXPECT_LT(glm::distance(sides_of(mass, moments, density), box), 1e-9);
  // A shell with a tenth of the mass and the same moments per kilogram has a tenth of the wall's thickness.
  EXPECT_NEAR(sides_of(0.1 * mass, 0.1 * moments, density).z, 0.1 * box.z, 1e-9);
}

TEST(Modes, HardAndFastContactsAreShort) {
  const SoundMaterial &glass = sound_material("glass"), &wood = sound_material("wood");
  const double slow = contact_time(1, glass, 0, glass, 0.01, 1);
  EXPECT_LT(slow, contact_time(1, wood, 0, wood, 0.01, 1));
  EXPECT_NEAR(contact_time(1, glass, 0, glass, 0.01, 32) / slow, 0.5, 1e-9);  // v^(-1/5)
  EXPECT_NEAR(contact_time(2, glass, 2, glass, 0.01, 1) / slow, 1,
              1e-9);  // two of 2 kg are like one of 1 kg against a wall
}

TEST(Strikes, GlassRingsHigherAndLongerThanWood) {
  const Clip glass = strike(tile_of("glass"), 1, 1e-4), wood = strike(tile_of("wood"), 1, 1e-4);
  EXPECT_GT(spectral_peak(glass.samples), 1.5 * spectral_peak(wood.samples));
  EXPECT_GT(glass.samples.size(), wood.samples.size());
}

TEST(Strikes, GrowWithTheImpulseAndAreFaintWhereTheContactIsLong) {
  const auto modes = tile_of("ceramic");
  const Clip one = strike(modes, 1, 1e-3), two = strike(modes, 2, 1e-3), dull = strike(modes, 1, 5e-3);
  EXPECT_NEAR(two.pressure / one.pressure, 2, 1e-9);
  EXPECT_LE(one.pressure, loudest(modes, 1, 1e-3));
  const Clip bright = strike(modes, 1, 1e-5);
  EXPECT_GT(bright.pressure, 3 * dull.pressure);
}

TEST(Strikes, AreFiniteForEveryMaterialAndSize) {
  for (const char* name : kNames)
    for (const double scale : {0.01, 0.1, 1.0, 10.0}) {
      const Clip clip = strike(tile_of(name, scale), 100, 1e-4);
      if (clip.samples.empty()) continue;
      EXPECT_LE(clip.samples.size(), 1.5 * kRate) << name;
      float most = 0;
      for (const float x : clip.samples) {
        ASSERT_TRUE(std::isfinite(x)) << name << ", " << scale;
        most = std::max(most, std::abs(x));
      }
      EXPECT_LE(most, 1.f);
      EXPECT_GT(most, 0.5f) << name << ", " << scale;
      EXPECT_LT(std::abs(clip.samples.back()), 1e-3f) << "it ends with a step";
    }
}

TEST(SpeakersTest, LoudnessFallsWithTheDistance) {
  const double near = loudness(heard({0, 0, -3})), far = loudness(heard({0, 0, -6})),
               farther = loudness(heard({0, 0, -24}));
  ASSERT_GT(near, 0.001);
  EXPECT_NEAR(near / far, 2, 0.02);
  EXPECT_NEAR(near / farther, 8, 0.08);
}

TEST(SpeakersTest, WhatIsOnTheRightIsLouderThere) {
  const std::vector<float> right = heard({4, 0, 0});
  EXPECT_GT(loudness(channel(right, 1)), 2 * loudness(channel(right, 0)));
}

TEST(SpeakersTest, SilenceIsZeroAndEqualSoundsAreEqualBytes) {
  {
    Expected<Speakers> speakers = Speakers::loopback();
    ASSERT_TRUE(speakers) << speakers.error().detail;
    std::vector<float> samples(2 * kRate / 10, 1.f);
    speakers->render(samples);
    EXPECT_EQ(samples, std::vector<float>(samples.size(), 0.f));
  }
  EXPECT_EQ(heard({1, 2, -3}), heard({1, 2, -3}));
}

TEST(SpeakersTest, AtMostSoManyVoicesTheFaintestGoes) {
  Expected<Speakers> speakers = Speakers::loopback();
  ASSERT_TRUE(speakers) << speakers.error().detail;
  const Clip clip = strike(tile_of("metal"), 1, 1e-4);
  for (std::size_t k = 0; k < 3 * Speakers::kVoices; ++k) speakers->play(clip, {0, 0, -1}, 0.001);
  std::vector<float> faint(2 * kRate / 20), loud(2 * kRate / 20);
  speakers->render(faint);
  speakers->play(clip, {0, 0, -1}, 1);
  speakers->render(loud);
  EXPECT_GT(loudness(loud), 3 * loudness(faint));
}

TEST(Wav, HoldsWhatWasAddedAndClipsNothing) {
  test::TemporaryFolder folder;
  const std::string path = folder / "sound.wav";
  Expected<WavFile> file = WavFile::create(path);
  ASSERT_TRUE(file) << file.error().detail;
  const std::vector<float> samples = {0, 0.1f, -0.1f, 1, -1, 50, -50, 0};
  file->add(samples);
  ASSERT_TRUE(file->finish());
  std::ifstream in(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  ASSERT_EQ(bytes.size(), 44 + 2 * samples.size());
  const auto number = [&](std::size_t at, int count) {
    std::uint32_t value = 0;
    for (int k = 0; k < count; ++k)
      value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + static_cast<std::size_t>(k)]))
               << (8 * k);
    return value;
  };
  EXPECT_EQ(bytes.substr(0, 4) + bytes.substr(8, 8) + bytes.substr(36, 4), "RIFFWAVEfmt data");
  EXPECT_EQ(number(4, 4), bytes.size() - 8);
  EXPECT_EQ(number(22, 2), 2u);
  EXPECT_EQ(number(24, 4), static_cast<std::uint32_t>(kRate));
  EXPECT_EQ(number(40, 4), 2 * samples.size());
  std::vector<int> read;
  for (std::size_t k = 0; k < samples.size(); ++k)
    read.push_back(static_cast<std::int16_t>(number(44 + 2 * k, 2)));
  EXPECT_EQ(read[0], 0);
  EXPECT_EQ(read[1], 3277);  // unchanged
  EXPECT_EQ(read[1], -read[2]);
  EXPECT_GT(read[5], read[3]);  // louder samples stay louder
  EXPECT_LE(read[5], 32767);
}

TEST(Wav, APipeIsRefusedAndNotWaitedFor) {
  test::TemporaryFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  const Expected<WavFile> pipe = WavFile::create(folder / "pipe");
  ASSERT_FALSE(pipe);
  EXPECT_EQ(pipe.error().code, ErrorCode::kFileAccess);
}

TEST(Wav, AFileThatCannotBeWrittenIsAnError) {
  const Expected<WavFile> nowhere = WavFile::create("/nowhere/sound.wav");
  ASSERT_FALSE(nowhere);
  EXPECT_EQ(nowhere.error().code, ErrorCode::kFileAccess);
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
  EXPECT_FALSE(WavFile::create("/dev/full"));
}

Voice shard(double impulse) {
  return {tile_of("glass"), impulse, 1e-4, {0, 0, -2}, loudest(tile_of("glass"), impulse, 1e-4)};
}

TEST(PlayerTest, EndsWhateverTheMachineHas) {
  for (int k = 0; k < 3; ++k) {
    Player player;
    for (int frame = 0; frame < 50; ++frame) {
      player.hear(std::vector<Voice>(8, shard(1)), {0, 0, 0}, {0, 0, -1});
      player.set_volume(0.01 * frame);
    }
  }
  SUCCEED();  // reaching this line is the test, because CTest has a time limit
}

world::Witnessed knocked(double impulse, std::uint64_t step, std::uint32_t fragment = 0) {
  world::Knock knock;
  knock.step = step;
  knock.impulse = impulse;
  knock.approach = 2;
  knock.a.kind = world::Knock::Side::Kind::kObject;
  knock.a.fragment = fragment;
  knock.a.mass = 3;
  knock.a.moments = {0.0101, 0.0226, 0.0325};  // a tile of 0.3 × 0.2 × 0.02 m
  return {{knock}, {}};
}

TEST(SoundscapeTest, OneVoiceForAKnockOnTheGroundAndNoneSoonAfterUnlessLouder) {
  const auto glass = [](world::ObjectId) { return std::string("glass"); };
  Soundscape soundscape;
  EXPECT_TRUE(soundscape.voices({}, glass).empty());
  EXPECT_EQ(soundscape.voices(knocked(1, 10), glass).size(), 1u);
  EXPECT_EQ(soundscape.voices(knocked(1, 12), glass).size(), 0u);
  EXPECT_EQ(soundscape.voices(knocked(20, 12), glass).size(), 1u);
  EXPECT_EQ(soundscape.voices(knocked(1, 12, 1), glass).size(), 1u);  // another body
  EXPECT_EQ(soundscape.voices(knocked(1, 40), glass).size(), 1u);
  EXPECT_EQ(soundscape.voices(knocked(1e-9, 80), glass).size(), 0u);  // too quiet to hear
}

TEST(SoundscapeTest, AStepHasItsLoudestVoicesOnly) {
  Soundscape soundscape;
  world::Witnessed all;
  for (std::uint32_t k = 0; k < 200; ++k) all.knocks.push_back(knocked(1 + k, 5, k).knocks[0]);
  const auto voices = soundscape.voices(all, [](world::ObjectId) { return std::string("glass"); });
  ASSERT_EQ(voices.size(), Soundscape::kVoicesPerStep);
  for (const Voice& voice : voices) EXPECT_GT(voice.impulse, 150);
}

TEST(SoundscapeTest, CracksAreHeardByTheirMaterial) {
  world::Witnessed cracks;
  cracks.cracks.push_back(
      {.step = 3, .area = 0.004, .strength = 1.2e5, .mass = 3, .moments = {0.0101, 0.0226, 0.0325}});
  Soundscape soundscape;
  const auto voices = soundscape.voices(cracks, [](world::ObjectId) { return std::string("glass"); });
  ASSERT_EQ(voices.size(), 1u);
  EXPECT_GT(amplitude_of(voices[0].loudest), 0.01);
  EXPECT_LE(amplitude_of(1e12), 1);
  EXPECT_NEAR(amplitude_of(4) / amplitude_of(1), 2, 1e-9);
}

}  // namespace
}  // namespace fracture::sound
