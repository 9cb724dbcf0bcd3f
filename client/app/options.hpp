// What the command line says.
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

/// Port 0: none.
struct Address {
  std::string host = "127.0.0.1";
  std::uint16_t port = 0;
};

struct Options {
  std::string scene = "monkey";
  std::vector<std::string> files;  ///< meshes or folders, instead of a scene
  std::string material;            ///< empty: the scene's own
  std::string unit;                ///< of own files: m, cm, mm or inch; empty: a guess by their size
  nlohmann::json parameters = nlohmann::json::object();  ///< of every fracture, above what scene and hit say
  protocol::Settings server;
  std::uint64_t seed = 1;
  int width = 1280, height = 720;
  render::TierWish picture = render::TierWish::kAuto;  ///< without a window auto is low
  bool anticipate = true;

  double close_after = 0;  ///< seconds; 0: when the player leaves. Leaves a picture window.png
  bool gravity = false;    ///< starts with gravity on
  bool sound = true;

  std::string log;            ///< file that the game is recorded in; empty: none
  std::string continue_from;  ///< such a file, played to its end, where the player goes on; empty: none

  Address invite, join;  ///< of another player; at most one of them

  bool headless = false;
  std::string replay;  ///< such a file, to be played again; empty: none
  bool fixed_step = false;
  std::chrono::milliseconds longest_absence{60'000};  ///< of a server for which a reproducible run waits
  unsigned answer_steps = 6;  ///< fixed_step: from a request to its answer's effect (50 ms)
  double seconds = 5;
  std::vector<double> screenshots;  ///< seconds
  std::string record;               ///< .mp4, .gif, .webp or a folder, of every frame; empty: none
  bool effects = true;              ///< dust, crumbs and marks
  std::string wav;                  ///< file that is heard what happens; empty: none
  bool draw = false;                ///< every frame is drawn, and read by nobody: what submitting costs
  std::string out = ".";
  bool json = false;
  bool throws = true;                      ///< what the scene throws by itself; headless only
  std::vector<scenes::TimedBlast> blasts;  ///< in the order of their times; headless only
  bool requests = true;                    ///< false: hits ask for nothing; headless only
};

struct Exit {
  int code = 0;
};

/// Options, or the code to exit with: help was shown (0), or the command line is wrong (2, said on stderr).
tl::expected<Options, Exit> parse_options(int argc, char** argv);

}  // namespace fracture::app
