#include "client/game/history.hpp"

#include <algorithm>

#include "common/base/json_text.hpp"

namespace fracture::game {

History::History(nlohmann::json header, std::size_t most_bytes) : most_bytes_(most_bytes) {
  recording_.header = std::move(header);
}

bool History::has_room(std::size_t bytes) {
  full_ = full_ || bytes_ + bytes > most_bytes_;
  if (!full_) bytes_ += bytes;
  return !full_;
}

void History::add(RecordedEvent event) {
  if (has_room(sizeof event + (event.overrides.is_null() ? 0 : json_text(event.overrides).size())))
    recording_.events.push_back(std::move(event));
}

void History::add_hash(std::uint64_t fingerprint) {
  if (has_room(sizeof fingerprint)) recording_.hashes.push_back(fingerprint);
}

Recording History::until(std::uint64_t steps) const {
  Recording part;
  part.header = recording_.header;
  const auto count = static_cast<std::ptrdiff_t>(std::min(steps, this->steps()));
  part.hashes.assign(recording_.hashes.begin(), recording_.hashes.begin() + count);
  for (const RecordedEvent& event : recording_.events)
    if (event.step < part.hashes.size()) part.events.push_back(event);
  return part;
}

namespace {

std::string key_of(const std::string& mesh, const nlohmann::json& parameters) {
  return mesh + ' ' + json_text(parameters);
}

}  // namespace

std::shared_ptr<const Decoded> KeptAnswers::find(const std::string& mesh, const nlohmann::json& parameters,
                                                 const std::shared_ptr<const Decoded>& before) const {
  const auto known = answers_.find(key_of(mesh, parameters));
  return known == answers_.end() || known->second.before != before ? nullptr : known->second.answer;
}

void KeptAnswers::keep(const std::string& mesh, const nlohmann::json& parameters, Kept answer) {
  const std::size_t size = answer.answer->glb->size();
  if (bytes_ + size > most_bytes_) return;
  if (answers_.emplace(key_of(mesh, parameters), std::move(answer)).second) bytes_ += size;
}

}  // namespace fracture::game
