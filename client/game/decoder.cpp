#include "client/game/decoder.hpp"

#include <exception>
#include <map>

#include "client/world/touching.hpp"

namespace fracture::game {

Decoded decode(std::uint64_t ticket, std::string glb) {
  Decoded decoded;
  decoded.ticket = ticket;
  const auto bytes = std::as_bytes(std::span(glb.data(), glb.size()));
  Expected<world::FragmentSet> set = world::read_fragments(bytes);
  if (!set) {
    decoded.error = to_string(set.error());
    return decoded;
  }
  Expected<render::Model> model = render::read_model(bytes);
  if (!model) {
    decoded.error = to_string(model.error());
    return decoded;
  }
  std::map<std::uint64_t, std::uint32_t> index;
  for (std::uint32_t k = 0; k < set->fragments.size(); ++k) index[set->fragments[k].id] = k;
  for (const render::Object& object : model->objects) {
    const auto at = object.fragment ? index.find(object.fragment->id) : index.end();
    decoded.fragment_of_object.push_back(at == index.end() ? Decoded::kNoFragment : at->second);
  }
  decoded.model = std::make_shared<const render::Model>(std::move(*model));
  world::bond_touching_parts(*set);
  decoded.fragments = world::prepare(std::move(*set));
  decoded.glb = std::make_shared<const std::string>(std::move(glb));
  return decoded;
}

Decoder::Decoder() : thread_([this] { run(); }) {}

Decoder::~Decoder() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void Decoder::submit(std::uint64_t ticket, std::string glb) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.emplace_back(ticket, std::move(glb));
  }
  wake_.notify_one();
}

std::vector<Decoded> Decoder::poll() {
  const std::lock_guard lock(mutex_);
  return std::exchange(done_, {});
}

void Decoder::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return stopping_ || !waiting_.empty(); });
    if (stopping_) return;
    auto [ticket, glb] = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    Decoded decoded;
    try {
      decoded = decode(ticket, std::move(glb));
    } catch (const std::exception& error) {  // out of memory, or a bug: the game goes on
      decoded.ticket = ticket;
      decoded.error = error.what();
    }
    lock.lock();
    done_.push_back(std::move(decoded));
  }
}

}  // namespace fracture::game
