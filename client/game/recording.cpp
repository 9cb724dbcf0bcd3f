#include "client/game/recording.hpp"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include "common/base/json_text.hpp"

namespace fracture::game {
namespace {

using nlohmann::json;

constexpr const char* kFormat = "fracture-game-1";

json vector_of(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

glm::dvec3 read_vector(const json& list) {
  return {list.at(0).get<double>(), list.at(1).get<double>(), list.at(2).get<double>()};
}

/// `missing`: the value of an optional member that is missing.
double read_positive(const json& line, const char* name, std::optional<double> missing = {}) {
  if (missing && !line.contains(name)) return *missing;
  const double value = line.at(name).get<double>();
  if (!(value > 0)) throw std::invalid_argument(std::string(name) + " must be more than 0");
  return value;
}

/// Throws json::exception for an unknown line.
void read_line(const json& line, Recording& recording) {
  const auto hash = line.find("hash");
  if (hash == line.end()) {
    recording.events.push_back(event_of(line));
    return;
  }
  if (line.at("step").get<std::uint64_t>() != recording.hashes.size())
    throw std::runtime_error("its step must be the next one, " + std::to_string(recording.hashes.size()));
  recording.hashes.push_back(hash_of(hash->get<std::string>()));
}

/// Throws std::runtime_error if the format or the rules differ from those of this program.
void check_version(const json& header) {
  if (const json& format = header.at("format"); format != kFormat)
    throw std::runtime_error("its format is " + format.dump() + ", but this program plays \"" + kFormat +
                             "\"");
  // Old recordings have no rules. They are played, and a step that differs is reported.
  if (const auto rules = header.find("rules"); rules != header.end() && *rules != kRules)
    throw std::runtime_error("it was recorded by another version, with rules " + rules->dump() +
                             ", but this program uses rules " + std::to_string(kRules) +
                             ". Play it with the version that recorded it");
}

}  // namespace

RecordedEvent event_of(const json& line) {
  RecordedEvent event;
  event.step = line.at("step").get<std::uint64_t>();
  if (const auto thrown = line.find("throw"); thrown != line.end()) {
    event.kind = RecordedEvent::Kind::kThrow;
    event.from = read_vector(thrown->at(0));
    event.velocity = read_vector(thrown->at(1));
    event.radius = read_positive(line, "radius", 0);
    event.density = read_positive(line, "density", 0);
  } else if (const auto blast = line.find("explode"); blast != line.end()) {
    event.kind = RecordedEvent::Kind::kExplode;
    event.from = read_vector(*blast);
    event.impulse = read_positive(line, "impulse");
    event.radius = read_positive(line, "radius");
  } else if (line.contains("adopt")) {
    event.kind = RecordedEvent::Kind::kAdopt;
    event.request = line["adopt"].get<std::uint64_t>();
  } else if (line.contains("fail")) {
    event.kind = RecordedEvent::Kind::kFail;
    event.request = line["fail"].get<std::uint64_t>();
  } else if (line.contains("overrides")) {
    event.kind = RecordedEvent::Kind::kOverrides;
    event.overrides = line["overrides"];
  } else if (const auto mass = line.find("mass"); mass != line.end()) {
    event.kind = RecordedEvent::Kind::kMass;
    event.thing = line.at("thing").get<std::size_t>();
    event.factor = mass->get<double>();
  } else {
    event.kind = RecordedEvent::Kind::kEye;
    event.from = read_vector(line.at("eye"));
  }
  return event;
}

Expected<Recording> read_recording(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    return fail(ErrorCode::kFileAccess, path + " is a folder. Specify the file of a recorded game.");
  std::ifstream in(path);
  if (!in) return fail(ErrorCode::kFileAccess, "Cannot read " + path + ".");
  Recording recording;
  std::size_t number = 0;
  for (std::string text; std::getline(in, text);) {
    ++number;
    try {
      json line = json::parse(text);
      if (number > 1) {
        read_line(line, recording);
        continue;
      }
      check_version(line);
      recording.header = std::move(line);
    } catch (const std::exception& error) {
      recording.cut_off = in.eof() && number > 1;
      if (recording.cut_off) break;
      return fail(ErrorCode::kBadJson, path + ", line " + std::to_string(number) +
                                           ": not a line of a recorded game: " + json_trouble(error));
    }
  }
  if (number == 0) return fail(ErrorCode::kBadJson, path + " is empty, so it is not a recorded game.");
  return recording;
}

Expected<Recorder> Recorder::create(const std::string& path, const json& header) {
  std::ofstream out(path);
  json first = header;
  first["format"] = kFormat;
  first["rules"] = kRules;
  out << json_text(first) << '\n';
  if (!out.flush()) return fail(ErrorCode::kFileAccess, "Cannot write " + path + ".");
  return Recorder(std::move(out));
}

json line_of(const RecordedEvent& event) {
  json line = {{"step", event.step}};
  switch (event.kind) {
    case RecordedEvent::Kind::kThrow:
      line["throw"] = {vector_of(event.from), vector_of(event.velocity)};
      if (event.radius > 0) line["radius"] = event.radius;
      if (event.density > 0) line["density"] = event.density;
      break;
    case RecordedEvent::Kind::kExplode:
      line["explode"] = vector_of(event.from);
      line["impulse"] = event.impulse;
      line["radius"] = event.radius;
      break;
    case RecordedEvent::Kind::kAdopt:
      line["adopt"] = event.request;
      break;
    case RecordedEvent::Kind::kFail:
      line["fail"] = event.request;
      break;
    case RecordedEvent::Kind::kOverrides:
      line["overrides"] = event.overrides;
      break;
    case RecordedEvent::Kind::kMass:
      line["thing"] = event.thing;
      line["mass"] = event.factor;
      break;
    case RecordedEvent::Kind::kEye:
      line["eye"] = vector_of(event.from);
      break;
  }
  return line;
}

void Recorder::add(const RecordedEvent& event) { out_ << json_text(line_of(event)) << '\n'; }

void Recorder::add_hash(std::uint64_t step, std::uint64_t fingerprint) {
  out_ << hash_line(step, fingerprint) << '\n';
}

std::string hash_line(std::uint64_t step, std::uint64_t fingerprint) {
  char text[64];
  std::snprintf(text, sizeof text, R"({"step":%llu,"hash":"%016llx"})", static_cast<unsigned long long>(step),
                static_cast<unsigned long long>(fingerprint));
  return text;
}

std::uint64_t hash_of(const std::string& text) {
  constexpr std::size_t kDigits = 16;
  if (text.empty() || text.size() > kDigits ||
      text.find_first_not_of("0123456789abcdef") != std::string::npos)
    throw std::invalid_argument("its hash must have 1 to 16 hexadecimal digits");
  return std::strtoull(text.c_str(), nullptr, 16);
}

Expected<void> write_recording(const std::string& path, const Recording& recording) {
  Expected<Recorder> recorder = Recorder::create(path, recording.header);
  if (!recorder) return tl::unexpected(recorder.error());
  std::size_t next = 0;
  const auto add_events = [&](std::uint64_t until) {
    for (; next < recording.events.size() && recording.events[next].step <= until; ++next)
      recorder->add(recording.events[next]);
  };
  for (std::uint64_t step = 0; step < recording.hashes.size(); ++step) {
    add_events(step);
    recorder->add_hash(step, recording.hashes[step]);
  }
  add_events(recording.hashes.size());
  if (!recorder->finish())
    return fail(ErrorCode::kFileAccess,
                "Cannot finish writing the recording " + path + ". Is the disk full?");
  return {};
}

}  // namespace fracture::game
