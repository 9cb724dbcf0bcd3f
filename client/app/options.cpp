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

/// Adds NAME=VALUE as a member. VALUE is read as JSON, or as text if it is not JSON. Returns false if NAME is empty.
bool add_parameter(const std::string& text, nlohmann::json& parameters) {
  const std::size_t sign = text.find('=');
  if (sign == std::string::npos || sign == 0) return false;
  const std::string value = text.substr(sign + 1);
  nlohmann::json parsed = nlohmann::json::parse(value, nullptr, false);
  parameters[text.substr(0, sign)] = parsed.is_discarded() ? nlohmann::json(value) : std::move(parsed);
  return true;
}

/// Reads "T,x,y,z[,IMPULSE[,RADIUS]]". Returns the error if it is malformed.
tl::expected<scenes::TimedBlast, std::string> blast_of(const std::string& text) {
  const auto wrong = [&](const char* why) { return tl::unexpected("'" + text + "' " + why); };
  constexpr const char* kForm = "must be four to six numbers: T,x,y,z[,IMPULSE[,RADIUS]]";
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
  if (numbers[0] < 0) return wrong("has a negative time T; it must be 0 or more");
  scenes::TimedBlast blast{
      numbers[0], {{numbers[1], numbers[2], numbers[3]}, scenes::kBlastImpulse, scenes::kBlastRadius}};
  if (numbers.size() > kLeast) blast.blast.impulse = numbers[kLeast];
  if (numbers.size() == kMost) blast.blast.radius = numbers[kMost - 1];
  if (!(blast.blast.impulse > 0)) return wrong("has an invalid IMPULSE; it must be more than 0");
  if (!(blast.blast.radius > 0)) return wrong("has an invalid RADIUS; it must be more than 0");
  return blast;
}

/// Reads "[HOST:]PORT". Returns nothing if it is malformed.
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

/// Rejects NaN, which CLI::Range accepts.
std::string not_a_number(const std::string& text) {
  return std::isnan(std::strtod(text.c_str(), nullptr)) ? "'" + text + "' is not a number" : "";
}

/// Rejects numbers that do not fit, because the library would wrap or truncate them.
std::string no_seed(const std::string& text) {
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
  return error == std::errc() && end == text.data() + text.size()
             ? ""
             : "'" + text + "' must be a whole number from 0 to 18446744073709551615";
}

/// Rejects an empty name, which usually comes from an empty shell variable.
std::string not_empty(const std::string& text) { return text.empty() ? "the name is empty" : ""; }

}  // namespace

tl::expected<Options, Exit> parse_options(int argc, char** argv) {
  Options o;
  CLI::App app{"fracture-client: a game with objects that break. A fracture-server computes the fragments."};
  app.option_defaults()->always_capture_default();
  CLI::Option* files =
      app.add_option("files", o.files, "Meshes, or folders of meshes, to drop and break instead of a scene");
  files->capture_default_str();
  CLI::Option* scene = app.add_option("--scene", o.scene, "Scene");
  scene->check(CLI::IsMember(scenes::scene_names()));
  CLI::Option* material = app.add_option("--material", o.material, "Material of all objects");
  material->check(CLI::IsMember(scenes::material_names()));
  int sites = 0;
  CLI::Option* all_sites = app.add_option(
      "--sites", sites, "Number of sites in each fracture; 0: depends on the energy of the hit");
  all_sites->check(CLI::Range(0, 100000));
  std::vector<std::string> set;
  CLI::Option* set_values = app.add_option(
      "--set", set, "NAME=VALUE: a parameter for all fractures, as listed by GET /patterns; can be repeated");
  set_values->check([](const std::string& text) {
    nlohmann::json ignored;
    return add_parameter(text, ignored) ? std::string() : "'" + text + "' must be NAME=VALUE";
  });
  std::string assign;
  CLI::Option* assigned = app.add_option(
      "--assign", assign,
      "Materials of parts, as in bake --assign: 'Window_*:glass;slot=staves:wood', or a JSON list");
  assigned->check(not_empty);
  CLI::Option* unit =
      app.add_option("--unit", o.unit, "Coordinate unit of your meshes; default: guessed from their size");
  unit->check(CLI::IsMember({"m", "cm", "mm", "inch"}));
  app.add_option("--host", o.server.host, "Name or address of the server");
  app.add_option("--port", o.server.port, "Port of the server")->check(CLI::Range(1, 65535));
  app.add_option("--token", o.server.token, "Bearer token, if the server needs one");
  CLI::Option* seed = app.add_option("--seed", o.seed, "Seed for all fractures")->check(no_seed);
  app.add_option("--width", o.width, "Width of the picture in pixels")->check(CLI::Range(64, 4096));
  app.add_option("--height", o.height, "Height of the picture in pixels")->check(CLI::Range(64, 4096));
  std::string picture = render::kTierWishNames[static_cast<std::size_t>(o.picture)];
  app.add_option(
         "--picture", picture,
         "Picture quality. low: for computers without a graphics card. high: for computers with one. auto: high if "
         "the program has a window and a fast graphics card, otherwise low")
      ->check(CLI::IsMember(render::kTierWishNames));
  bool no_anticipation = false, no_throws = false, no_requests = false, no_sound = false, no_effects = false;
  CLI::Option* without_anticipation =
      app.add_flag("--no-anticipation", no_anticipation,
                   "Send requests when the ball hits, not while it is still in the air");
  app.add_flag("--gravity", o.gravity, "In a window: gravity is on from the start, without holding X");
  app.add_flag("--no-effects", no_effects, "No dust, crumbs or marks");
  app.add_flag("--no-sound", no_sound, "In a window: no sound");
  app.add_option("--close-after", o.close_after,
                 "In a window: after this many seconds, write window.png to the --out folder and close")
      ->check(not_a_number)
      ->check(CLI::Range(0.0, 86400.0));
  app.add_option("--out", o.out, "Folder for pictures and saved files");
  app.add_option("--log", o.log, "Record the game in this file, for --replay and --continue")
      ->check(not_empty);
  CLI::Option* resumed = app.add_option(
      "--continue", o.continue_from,
      "Play a game that was recorded with --log or F5, and continue from its end. Scene and settings come from the "
      "recording");
  resumed->check(not_empty);
  CLI::Option* headless = app.add_flag("--headless", o.headless, "Run without a window, then exit");
  const auto add = [&](CLI::Option* option) { option->needs(headless); };
  add(app.add_flag(
      "--fixed-step", o.fixed_step,
      "Make the run reproducible: an answer takes effect --answer-steps steps after its request, and "
      "simulated time pauses if the server needs longer"));
  add(app.add_option("--wav", o.wav,
                     "Sound file to write (WAV, 16 bits, stereo, 48 kHz); requires --fixed-step or --replay")
          ->check(not_empty));
  const auto is_address = [](const std::string& text) {
    return address_of(text) ? std::string()
                            : "'" + text + "' must be [HOST:]PORT with a port from 1 to 65535";
  };
  std::string invite, join;
  CLI::Option* invites =
      app.add_option("--invite", invite,
                     "[ADDRESS:]PORT on which another player can join this game; without an address, only "
                     "players on this machine can join (127.0.0.1)");
  invites->check(is_address);
  CLI::Option* joins = app.add_option(
      "--join", join,
      "[HOST:]PORT of a player who used --invite; that player sets the scene, the settings and --seconds");
  for (CLI::Option* option : {invites, joins}) add(option);
  joins->check(is_address)->excludes(invites)->excludes(resumed);
  invites->excludes(resumed)->excludes(files);
  for (CLI::Option* said : {scene, files, material, unit, seed, all_sites, set_values, assigned})
    joins->excludes(said);
  CLI::Option* replayed = app.add_option(
      "--replay", o.replay,
      "Replay a game that was recorded with --log, and compare each step with the recording. If a step differs, "
      "print the number of the first such step and exit with code 4");
  add(replayed->check(not_empty));
  replayed->excludes(resumed)->excludes(invites)->excludes(joins);
  // These come from the recording.
  for (CLI::Option* said : {scene, files, material, unit, seed, all_sites, set_values, assigned})
    resumed->excludes(said);
  CLI::Option* answer_steps =
      app.add_option("--answer-steps", o.answer_steps,
                     "Number of steps (1/120 s each) from a request until its answer takes effect");
  add(answer_steps->check(CLI::Range(1, 1200)));
  CLI::Option* seconds = app.add_option("--seconds", o.seconds, "Simulated time of the whole run in seconds");
  add(seconds->check(not_a_number)->check(CLI::Range(0.0, 3600.0)));
  add(app.add_option("--screenshot-at", o.screenshots,
                     "Take pictures at these simulated times in seconds, separated by commas")
          ->delimiter(',')
          ->check(not_a_number)
          ->check(CLI::Range(0.0, 3600.0)));
  add(app.add_option(
             "--record", o.record,
             "Film all frames (60 per second) to a file that ends in .mp4, .gif or .webp (requires ffmpeg), or to a "
             "folder of PNG frames, which must not contain an earlier film")
          ->check(not_empty));
  add(app.add_flag("--draw", o.draw,
                   "Draw every frame and discard the picture, to measure the cost of drawing"));
  add(app.add_flag("--json", o.json, "Print a summary as JSON"));
  CLI::Option* without_throws = app.add_flag("--no-throws", no_throws, "Do not throw the scene's own balls");
  add(without_throws);
  std::vector<std::string> blasts;
  add(app.add_option(
             "--explode", blasts,
             "T,x,y,z[,IMPULSE[,RADIUS]]: an explosion after T seconds at x,y,z (metres), with IMPULSE N·s (default: " +
                 std::to_string(std::llround(scenes::kBlastImpulse)) + ") and RADIUS metres (default: " +
                 std::to_string(std::llround(scenes::kBlastRadius)) + "); can be repeated")
          ->check([](const std::string& text) {
            const auto blast = blast_of(text);
            return blast ? std::string() : blast.error();
          }));
  CLI::Option* without_requests = app.add_flag(
      "--no-requests", no_requests, "Send no fracture requests, to compare the motion with and without them");
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
    std::fprintf(stderr, "--wav requires --fixed-step or --replay: only reproducible runs can write sound\n");
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
  if (!assign.empty()) add_parameter("assign=" + assign, o.parameters);
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
