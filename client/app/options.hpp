// The command line options.
#pragma once

#include <chrono>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "client/protocol/protocol.hpp"
#include "client/render/tier.hpp"
#include "client/scenes/scene.hpp"

namespace fracture::app {

/// Port 0: no address.
struct Address {
  std::string host = "127.0.0.1";
  std::uint16_t port = 0;
};

struct Options {
  std::string scene = "monkey";
  std::vector<std::string> files;  ///< meshes or folders to use instead of a scene
  std::string material;            ///< empty: the scene's own
  std::string unit;                ///< of the user's files: m, cm, mm or inch; empty: guessed from their size
  nlohmann::json parameters = nlohmann::json::object();  ///< override those of the scene and the hit
  protocol::Settings server;
  std::uint64_t seed = 1;
  int width = 1280, height = 720;
  render::TierWish picture = render::TierWish::kAuto;  ///< without a window, auto means low
  bool anticipate = true;

  double close_after = 0;  ///< seconds; 0: until the player quits. Then saves a picture, window.png
  bool gravity = false;    ///< gravity is on from the start
  bool sound = true;

  std::string log;            ///< file in which the game is recorded; empty: none
  std::string continue_from;  ///< recording to continue from its end; empty: none

  Address invite, join;  ///< of another player; at most one of them is set

  bool headless = false;
  std::string replay;  ///< recording to replay; empty: none
  bool fixed_step = false;
  std::chrono::milliseconds longest_absence{60'000};  ///< how long a reproducible run waits for a server
  unsigned answer_steps = 6;  ///< fixed_step: steps until the answer to a request takes effect (50 ms)
  double seconds = 5;
  std::vector<double> screenshots;  ///< in seconds
  std::string record;               ///< .mp4, .gif, .webp or a folder that receives every frame; empty: none
  bool effects = true;              ///< dust, crumbs and marks
  std::string wav;                  ///< file for the sound; empty: none
  bool draw = false;                ///< draw every frame and discard it, to measure the cost of submitting
  std::string out = ".";
  bool json = false;
  bool throws = true;                      ///< whether the scene throws its own balls; headless only
  std::vector<scenes::TimedBlast> blasts;  ///< in time order; headless only
  bool requests = true;                    ///< false: hits send no requests; headless only
};

struct Exit {
  int code = 0;
};

/// The options, or the exit code: 0 if help was shown, 2 if the command line is wrong (explained on stderr).
tl::expected<Options, Exit> parse_options(int argc, char** argv);

}  // namespace fracture::app
