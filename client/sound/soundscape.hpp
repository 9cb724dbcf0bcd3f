// Decides which of a game's knocks and cracks are heard, and how loud.
//
// Every body that is hit rings with its impulse. Every bond that breaks makes its lighter fragment ring with
// a share of the bond's stored energy. A step of a collapse has hundreds of both, so only the loudest are
// kept, and a body does not start again before it has been heard.
#pragma once

#include <functional>
#include <map>

#include "client/sound/clip.hpp"
#include "client/world/world.hpp"

namespace fracture::sound {

/// A sound to play.
struct Voice {
  std::vector<Mode> modes;
  double impulse = 0;  ///< N·s
  double contact = 0;  ///< seconds
  glm::dvec3 where{0};
  double loudest = 0;  ///< Pa at one metre; upper bound
};

/// An amplitude of 0 … 1 for a pressure (Pa at one metre). Between a settling shard and a falling wall there
/// are 100 dB, more than loudspeakers in a room can reproduce. So differences in decibels are halved.
double amplitude_of(double pressure);

class Soundscape {
 public:
  using MaterialOf = std::function<std::string(world::ObjectId)>;

  /// The loudest voices first, at most kVoicesPerStep per step. Equal arguments and histories give equal
  /// results.
  std::vector<Voice> voices(const world::Witnessed& witnessed, const MaterialOf& material_of);

  static constexpr std::size_t kVoicesPerStep = 6;

 private:
  struct Heard {
    std::uint64_t step = 0;
    double loudest = 0;
  };
  struct Source {  ///< the part that rings
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
