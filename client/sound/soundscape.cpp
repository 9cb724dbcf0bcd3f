#include "client/sound/soundscape.hpp"

#include <algorithm>
#include <cmath>

namespace fracture::sound {
namespace {

constexpr double kFaintest = 0.02;  // Pa at one metre: 60 dB, like speech in the same room
constexpr std::uint64_t kMasking =
    8;  // steps: 67 ms, in which a louder sound of the same body covers another
constexpr double kRinging =
    0.01;  // share of a bond's energy that becomes vibration; the crack takes the rest
constexpr double kCrackSpeed = 1000;  // m/s: cracks in brittle materials run at a third of the speed of sound
constexpr double kFullPressure = 60;  // Pa at one metre, played with the amplitude kFullAmplitude
constexpr double kFullAmplitude = 0.45;
constexpr int kCrackKind = 3;

constexpr std::size_t kLookedAt =
    32;  // knocks, and cracks, per call: modes of all of them would take a whole frame
constexpr std::size_t kRemembered = 4096;

/// The items with the largest `key`, in their original order.
template <class Item, class Key>
std::vector<Item> hardest(std::vector<Item> items, Key key) {
  if (items.size() <= kLookedAt) return items;
  std::vector<double> keys;
  for (const Item& item : items) keys.push_back(key(item));
  std::nth_element(keys.begin(), keys.begin() + kLookedAt - 1, keys.end(), std::greater<>());
  const double least = keys[kLookedAt - 1];
  std::erase_if(items, [&](const Item& item) { return key(item) < least; });
  return items;
}

std::uint64_t mix(std::uint64_t a, std::uint64_t b) {
  return (a ^ (b + 0x9e3779b97f4a7c15ull)) * 0xff51afd7ed558ccdull;
}

}  // namespace

double amplitude_of(double pressure) {
  return std::min(1.0, kFullAmplitude * std::sqrt(std::max(pressure, 0.0) / kFullPressure));
}

bool Soundscape::masked(const Candidate& candidate) {
  if (heard_.size() > kRemembered)
    std::erase_if(heard_, [&](const auto& entry) { return candidate.step - entry.second.step >= kMasking; });
  Heard& last = heard_[candidate.source];
  const double now = candidate.voice.loudest;
  if (last.loudest > 0 && candidate.step - last.step < kMasking && now < 2 * last.loudest) return true;
  last = {candidate.step, now};
  return false;
}

std::vector<Voice> Soundscape::voices(const world::Witnessed& witnessed, const MaterialOf& material_of) {
  using Kind = world::Knock::Side::Kind;
  std::vector<Candidate> all;
  // The ground and everything fixed to it sounds like concrete, and balls like iron.
  const auto material = [&](const world::Knock::Side& side) -> const SoundMaterial& {
    return sound_material(side.kind == Kind::kObject ? material_of(side.object)
                          : side.kind == Kind::kBall ? "cast_iron"
                                                     : "concrete");
  };
  const auto knocks = hardest(witnessed.knocks, [](const world::Knock& knock) { return knock.impulse; });
  for (const world::Knock& knock : knocks) {
    const SoundMaterial &a = material(knock.a), &b = material(knock.b);
    const glm::dvec3 sides_a = sides_of(knock.a.mass, knock.a.moments, a.density),
                     sides_b = sides_of(knock.b.mass, knock.b.moments, b.density);
    // A corner or an edge makes the contact; its radius is a tenth of the smaller body's middle side.
    const double size_a = knock.a.mass > 0 ? sides_a.y : 1, size_b = knock.b.mass > 0 ? sides_b.y : 1;
    const double contact =
        contact_time(knock.a.mass, a, knock.b.mass, b, 0.1 * std::min(size_a, size_b), knock.approach);
    for (const bool first : {true, false}) {
      const world::Knock::Side& side = first ? knock.a : knock.b;
      if (side.kind == Kind::kFixed) continue;
      Candidate candidate{
          {static_cast<int>(side.kind), side.object, side.fragment.value_or(0)}, knock.step, {}};
      Voice& voice = candidate.voice;
      voice.modes = modes_of(first ? a : b, side.mass, first ? sides_a : sides_b, side.held,
                             mix(mix(knock.step, side.object), side.fragment.value_or(7)));
      voice.impulse = knock.impulse;
      voice.contact = contact;
      voice.where = knock.point;
      voice.loudest = loudest(voice.modes, voice.impulse, contact);
      if (voice.loudest > kFaintest) all.push_back(std::move(candidate));
    }
  }
  const auto cracks = hardest(witnessed.cracks, [](const world::Crack& crack) { return crack.area; });
  for (const world::Crack& crack : cracks) {
    const SoundMaterial& of = sound_material(material_of(crack.object));
    if (!(crack.area > 0)) continue;
    const double size = std::sqrt(crack.area);
    // Energy stored in a bond of this area at its strength, if the bond is as deep as it is wide.
    const double energy = crack.strength * crack.strength * size / (2 * of.young * crack.area);
    Candidate candidate{{kCrackKind, crack.object, crack.bond}, crack.step, {}};
    Voice& voice = candidate.voice;
    voice.modes = modes_of(of, crack.mass, sides_of(crack.mass, crack.moments, of.density), false,
                           mix(mix(crack.step, crack.object), crack.bond));
    voice.impulse = std::sqrt(2 * crack.mass * kRinging * energy);
    voice.contact = size / kCrackSpeed;
    voice.where = crack.point;
    voice.loudest = loudest(voice.modes, voice.impulse, voice.contact);
    if (voice.loudest > kFaintest) all.push_back(std::move(candidate));
  }
  std::stable_sort(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) {
    return a.voice.loudest != b.voice.loudest ? a.voice.loudest > b.voice.loudest : a.source < b.source;
  });
  std::vector<Voice> result;
  std::map<std::uint64_t, std::size_t> in_step;
  for (Candidate& candidate : all) {
    std::size_t& count = in_step[candidate.step];
    if (count >= kVoicesPerStep || masked(candidate)) continue;
    ++count;
    result.push_back(std::move(candidate.voice));
  }
  return result;
}

}  // namespace fracture::sound
