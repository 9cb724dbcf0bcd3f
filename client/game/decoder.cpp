#include "client/game/decoder.hpp"

#include <exception>
#include <map>

namespace fracture::game {

namespace {

using Fragments = std::shared_ptr<const world::PreparedFragments>;

Expected<Fragments> read_whole(std::span<const std::byte> glb) {
  Expected<world::FragmentSet> set = world::read_fragments(glb);
  if (!set) return tl::unexpected(set.error());
  return world::prepare(std::move(*set));
}

Expected<Fragments> read_change(std::span<const std::byte> glb, const Fragments& before) {
  Expected<world::FragmentChange> change = world::read_change(glb);
  if (!change) return tl::unexpected(change.error());
  return world::prepare(before, std::move(*change));
}

}  // namespace

Decoded decode(std::uint64_t ticket, std::string glb, const std::shared_ptr<const Decoded>& before) {
  Decoded decoded;
  decoded.ticket = ticket;
  const auto bytes = std::as_bytes(std::span(glb.data(), glb.size()));
  Expected<Fragments> fragments = before ? read_change(bytes, before->fragments) : read_whole(bytes);
  if (!fragments) {
    decoded.error = to_string(fragments.error());
    return decoded;
  }
  Expected<render::Model> model = render::read_model(bytes);
  if (!model) {
    decoded.error = to_string(model.error());
    return decoded;
  }
  if (before) decoded.layers = before->layers;
  for (Decoded::Layer& layer : decoded.layers)
    for (std::uint32_t& fragment : layer.fragment_of_object)
      if (fragment != Decoded::kNoFragment && world::is_replaced(**fragments, fragment))
        fragment = Decoded::kNoFragment;
  const world::FragmentSet& set = world::fragments_of(**fragments);
  std::map<std::uint64_t, std::uint32_t> index;
  for (std::uint32_t k = 0; k < set.fragments.size(); ++k)
    if (!set.fragments[k].gone) index[set.fragments[k].id] = k;
  Decoded::Layer& layer = decoded.layers.emplace_back();
  for (const render::Object& object : model->objects) {
    const auto at = object.fragment ? index.find(object.fragment->id) : index.end();
    layer.fragment_of_object.push_back(at == index.end() ? Decoded::kNoFragment : at->second);
  }
  layer.model = std::make_shared<const render::Model>(std::move(*model));
  decoded.fragments = std::move(*fragments);
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

void Decoder::submit(std::uint64_t ticket, std::string glb, std::shared_ptr<const Decoded> before) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back({ticket, std::move(glb), std::move(before)});
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
    auto [ticket, glb, before] = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    Decoded decoded;
    try {
      decoded = decode(ticket, std::move(glb), before);
    } catch (const std::exception& error) {  // out of memory, or a bug; the game continues
      decoded.ticket = ticket;
      decoded.error = error.what();
    }
    lock.lock();
    done_.push_back(std::move(decoded));
  }
}

}  // namespace fracture::game
