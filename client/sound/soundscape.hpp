// What of a game's knocks and cracks is heard, and how loud.
//
// Every body that is met rings with the impulse it got; every bond that breaks sets its lighter fragment ringing with a
// share of the energy that the bond had stored. A step of a collapse has hundreds of both: the loudest are kept, and no
// body begins again before it has been heard.
#pragma once

#include <functional>
#include <map>

#include "client/sound/clip.hpp"
#include "client/world/world.hpp"

namespace fracture::sound {

/// Something to play.
struct Voice {
  std::vector<Mode> modes;
  double impulse = 0;  ///< N·s
  double contact = 0;  ///< seconds
  glm::dvec3 where{0};
  double loudest = 0;  ///< Pa at one metre, at most
};

/// An amplitude of 0 … 1 for a pressure (Pa at one metre). From a shard that settles to a wall that falls are 100 dB,
/// which no loudspeaker in a room has: as many decibels become half of them.
double amplitude_of(double pressure);

class Soundscape {
 public:
  using MaterialOf = std::function<std::string(world::ObjectId)>;

  /// The loudest first, at most kVoicesPerStep for each step that is in it. Equal for equal arguments and histories.
  std::vector<Voice> voices(const world::Witnessed& witnessed, const MaterialOf& material_of);

  static constexpr std::size_t kVoicesPerStep = 6;

 private:
  struct Heard {
    std::uint64_t step = 0;
    double loudest = 0;
  };
  struct Source {  ///< what rings
    int kind = 0;
    world::ObjectId object = 0;
    std::uint32_t part = 0;
    auto operator<=>(const Source&) const = default;
  };
  struct Candidate {
    Source source;
    std::uint64_t step = 0;
    Voice voice;
  };
  bool masked(const Candidate& candidate);

  std::map<Source, Heard> heard_;
};

}  // namespace fracture::sound
