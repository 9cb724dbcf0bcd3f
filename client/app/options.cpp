#include "client/app/options.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>

#include "client/app/output_places.hpp"
#include "client/scenes/scene.hpp"
#include "common/base/exit_codes.hpp"

namespace fracture::app {
namespace {

/// NAME=VALUE as a member: numbers, lists and so on as JSON, everything else as text. False: there is no name.
bool add_parameter(const std::string& text, nlohmann::json& parameters) {
  const std::size_t sign = text.find('=');
  if (sign == std::string::npos || sign == 0) return false;
  const std::string value = text.substr(sign + 1);
  nlohmann::json parsed = nlohmann::json::parse(value, nullptr, false);
  parameters[text.substr(0, sign)] = parsed.is_discarded() ? nlohmann::json(value) : std::move(parsed);
  return true;
}

/// "T,x,y,z[,IMPULSE[,RADIUS]]", or what is wrong with it.
tl::expected<scenes::TimedBlast, std::string> blast_of(const std::string& text) {
  const auto wrong = [&](const char* why) { return tl::unexpected("'" + text + "' " + why); };
  constexpr const char* kForm = "is not T,x,y,z[,IMPULSE[,RADIUS]] in numbers";
  std::vector<double> numbers;
  const char* at = text.c_str();
  for (char* end = nullptr;; at = end + 1) {
    const double number = std::strtod(at, &end);
    if (end == at || !std::isfinite(number) || (*end != '\0' && *end != ',')) return wrong(kForm);
    numbers.push_back(number);
    if (*end == '\0') break;
  }
  constexpr std::size_t kLeast = 4, kMost = 6;
  if (numbers.size() < kLeast || numbers.size() > kMost) return wrong(kForm);
  if (numbers[0] < 0) return wrong("explodes before the start: T is less than 0");
  scenes::TimedBlast blast{
      numbers[0], {{numbers[1], numbers[2], numbers[3]}, scenes::kBlastImpulse, scenes::kBlastRadius}};
  if (numbers.size() > kLeast) blast.blast.impulse = numbers[kLeast];
  if (numbers.size() == kMost) blast.blast.radius = numbers[kMost - 1];
  if (!(blast.blast.impulse > 0)) return wrong("has an impulse that is not more than 0");
  if (!(blast.blast.radius > 0)) return wrong("has a radius that is not more than 0");
  return blast;
}

/// "[HOST:]PORT"; nothing where it is not that.
std::optional<Address> address_of(const std::string& text) {
  Address address;
  const std::size_t colon = text.rfind(':');
  if (colon != std::string::npos) address.host = text.substr(0, colon);
  if (address.host.size() > 1 && address.host.front() == '[' && address.host.back() == ']')
    address.host = address.host.substr(1, address.host.size() - 2);  // RFC 3986, 3.2.2: an IPv6 address
  const std::string port = colon == std::string::npos ? text : text.substr(colon + 1);
  constexpr std::size_t kDigits = 5;
  if (address.host.empty() || port.empty() || port.size() > kDigits ||
      port.find_first_not_of("0123456789") != std::string::npos)
    return std::nullopt;
  const unsigned long number = std::strtoul(port.c_str(), nullptr, 10);
  if (number == 0 || number > 65535) return std::nullopt;
  address.port = static_cast<std::uint16_t>(number);
  return address;
}

/// As CLI::Range, which takes what is no number for one between the two.
std::string not_a_number(const std::string& text) {
  return std::isnan(std::strtod(text.c_str(), nullptr)) ? "'" + text + "' is no number" : "";
}

/// A number without a sign that fits: what does not is wrapped or cut by the library that reads it.
std::string no_seed(const std::string& text) {
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
  return error == std::errc() && end == text.data() + text.size()
             ? ""
             : "'" + text + "' is not a whole number from 0 to 18446744073709551615";
}

/// An empty variable of a script is no wish to go without.
std::string not_empty(const std::string& text) { return text.empty() ? "a name is missing: it was ''" : ""; }

}  // namespace

tl::expected<Options, Exit> parse_options(int argc, char** argv) {
  Options o;
  CLI::App app{"fracture-client: things that break, with a fracture-server that breaks them"};
  app.option_defaults()->always_capture_default();
  CLI::Option* files =
      app.add_option("files", o.files, "Meshes, or folders of meshes, to drop and break instead of a scene");
  files->capture_default_str();
  CLI::Option* scene = app.add_option("--scene", o.scene, "Scene");
  scene->check(CLI::IsMember(scenes::scene_names()));
  CLI::Option* material = app.add_option("--material", o.material, "Material of everything in it");
  material->check(CLI::IsMember(scenes::material_names()));
  int sites = 0;
  CLI::Option* all_sites =
      app.add_option("--sites", sites, "Sites of every fracture; 0: as many as the hit asks for");
  all_sites->check(CLI::Range(0, 100000));
  std::vector<std::string> set;
  CLI::Option* set_values = app.add_option(
      "--set", set, "NAME=VALUE: any parameter of GET /patterns, for every fracture; may be repeated");
  set_values->check([](const std::string& text) {
    nlohmann::json ignored;
    return add_parameter(text, ignored) ? std::string() : "'" + text + "' is not NAME=VALUE";
  });
  CLI::Option* unit =
      app.add_option("--unit", o.unit, "Unit of own meshes' coordinates; without it a guess by their size");
  unit->check(CLI::IsMember({"m", "cm", "mm", "inch"}));
  app.add_option("--host", o.server.host, "Server: name or address");
  app.add_option("--port", o.server.port, "Server: port")->check(CLI::Range(1, 65535));
  app.add_option("--token", o.server.token, "Bearer token, where the server asks for one");
  CLI::Option* seed = app.add_option("--seed", o.seed, "Seed of the fractures")->check(no_seed);
  app.add_option("--width", o.width, "Pixels")->check(CLI::Range(64, 4096));
  app.add_option("--height", o.height, "Pixels")->check(CLI::Range(64, 4096));
  std::string picture = render::kTierWishNames[static_cast<std::size_t>(o.picture)];
  app.add_option(
         "--picture", picture,
         "Tier of the picture: low, which two cores draw without a graphics card; high, for one; auto: in "
         "the window high where the card has room for it, else low")
      ->check(CLI::IsMember(render::kTierWishNames));
  bool no_anticipation = false, no_throws = false, no_requests = false, no_sound = false, no_effects = false;
  CLI::Option* without_anticipation =
      app.add_flag("--no-anticipation", no_anticipation, "Ask at the contact, not when a ball is on its way");
  app.add_flag("--gravity", o.gravity, "Window: gravity runs from the start, without holding X");
  app.add_flag("--no-effects", no_effects, "Without dust, crumbs and marks");
  app.add_flag("--no-sound", no_sound, "Window: silent");
  app.add_option("--close-after", o.close_after,
                 "Window: closes after so many seconds and leaves window.png in --out")
      ->check(not_a_number)
      ->check(CLI::Range(0.0, 86400.0));
  app.add_option("--out", o.out, "Folder for pictures and saved files");
  app.add_option("--log", o.log, "File that the game is recorded in, to be played again")->check(not_empty);
  CLI::Option* resumed = app.add_option(
      "--continue", o.continue_from,
      "Plays a game that --log or the window recorded to its end, and goes on from there; what "
      "it was played with stands in it");
  resumed->check(not_empty);
  CLI::Option* headless = app.add_flag("--headless", o.headless, "Without a window, then exit");
  const auto add = [&](CLI::Option* option) { option->needs(headless); };
  add(app.add_flag("--fixed-step", o.fixed_step,
                   "Reproducible: answers take effect after --answer-steps, and the simulated clock stands "
                   "still for a slower server"));
  add(app.add_option("--wav", o.wav,
                     "File of what is heard: 16 bits, stereo, 48 kHz; needs --fixed-step or --replay")
          ->check(not_empty));
  const auto is_address = [](const std::string& text) {
    return address_of(text) ? std::string() : "'" + text + "' is not [HOST:]PORT";
  };
  std::string invite, join;
  CLI::Option* invites =
      app.add_option("--invite", invite,
                     "[ADDRESS:]PORT where another player may join this game; 127.0.0.1 alone "
                     "where no address is given");
  invites->check(is_address);
  CLI::Option* joins = app.add_option(
      "--join", join, "[HOST:]PORT of a player who invites: that one's scene, settings and seconds");
  for (CLI::Option* option : {invites, joins}) add(option);
  joins->check(is_address)->excludes(invites)->excludes(resumed);
  invites->excludes(resumed)->excludes(files);
  for (CLI::Option* said : {scene, files, material, unit, seed, all_sites, set_values}) joins->excludes(said);
  CLI::Option* replayed = app.add_option(
      "--replay", o.replay,
      "Plays a game that --log recorded; exit code 4, and the first step, if it is not the same");
  add(replayed->check(not_empty));
  replayed->excludes(resumed)->excludes(invites)->excludes(joins);
  // The recording says it.
  for (CLI::Option* said : {scene, files, material, unit, seed, all_sites, set_values})
    resumed->excludes(said);
  CLI::Option* answer_steps = app.add_option("--answer-steps", o.answer_steps, "Steps of 1/120 s");
  add(answer_steps->check(CLI::Range(1, 1200)));
  CLI::Option* seconds = app.add_option("--seconds", o.seconds, "Simulated time, all of it");
  add(seconds->check(not_a_number)->check(CLI::Range(0.0, 3600.0)));
  add(app.add_option("--screenshot-at", o.screenshots, "Seconds, separated by commas")
          ->delimiter(',')
          ->check(not_a_number)
          ->check(CLI::Range(0.0, 3600.0)));
  add(app.add_option(
             "--record", o.record,
             "Film of every frame (60 a second): a file that ends with .mp4, .gif or .webp (by ffmpeg, where that "
             "is installed), or a folder of PNG, which must have none of an earlier film")
          ->check(not_empty));
  add(app.add_flag("--draw", o.draw, "Draws every frame without keeping it: what submitting costs"));
  add(app.add_flag("--json", o.json, "A summary on standard output"));
  CLI::Option* without_throws =
      app.add_flag("--no-throws", no_throws, "Leave out the balls that the scene throws by itself");
  add(without_throws);
  std::vector<std::string> blasts;
  add(app.add_option(
             "--explode", blasts,
             "T,x,y,z[,IMPULSE[,RADIUS]]: an explosion after T seconds at a place in metres, with so many N·s (" +
                 std::to_string(std::llround(scenes::kBlastImpulse)) + ") that reach so many metres (" +
                 std::to_string(std::llround(scenes::kBlastRadius)) + "); may be repeated")
          ->check([](const std::string& text) {
            const auto blast = blast_of(text);
            return blast ? std::string() : blast.error();
          }));
  CLI::Option* without_requests =
      app.add_flag("--no-requests", no_requests, "Hits ask for nothing: the same motion, for comparisons");
  add(without_requests);
  for (CLI::Option* said : {answer_steps, seconds, without_anticipation, without_throws, without_requests})
    joins->excludes(said);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return tl::unexpected(Exit{code == 0 ? kExitDone : kExitUsage});
  }
  if (!o.wav.empty() && !o.fixed_step && o.replay.empty()) {
    std::fprintf(stderr, "--wav requires --fixed-step or --replay\n");
    return tl::unexpected(Exit{kExitUsage});
  }
  if (const std::optional<std::string> lost = same_place(o)) {
    std::fprintf(stderr, "%s\n", lost->c_str());
    return tl::unexpected(Exit{kExitUsage});
  }
  if (!invite.empty()) o.invite = *address_of(invite);
  if (!join.empty()) o.join = *address_of(join);
  if (sites > 0) o.parameters["sites"] = sites;
  for (const std::string& text : blasts) o.blasts.push_back(*blast_of(text));
  std::stable_sort(o.blasts.begin(), o.blasts.end(),
                   [](const auto& a, const auto& b) { return a.time < b.time; });
  for (const std::string& text : set) add_parameter(text, o.parameters);
  const auto wish = std::find(render::kTierWishNames.begin(), render::kTierWishNames.end(), picture);
  o.picture = static_cast<render::TierWish>(wish - render::kTierWishNames.begin());
  o.sound = !no_sound;
  o.effects = !no_effects;
  o.anticipate = !no_anticipation;
  o.throws = !no_throws;
  o.requests = !no_requests;
  return o;
}

}  // namespace fracture::app
