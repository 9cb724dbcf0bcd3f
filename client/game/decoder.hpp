// GLB answers become what the frame can use at once (collision shapes, vertices) on a thread of their own.
#pragma once

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "client/render/model.hpp"
#include "client/world/world.hpp"

namespace fracture::game {

struct Decoded {
  std::uint64_t ticket = 0;
  std::string error;  ///< for people: what is wrong with the file, where `fragments` is null; else empty
  std::shared_ptr<const std::string> glb;
  std::shared_ptr<const world::PreparedFragments> fragments;
  std::shared_ptr<const render::Model> model;
  std::vector<std::uint32_t> fragment_of_object;  ///< per object of the model; kNoFragment for others
  static constexpr std::uint32_t kNoFragment = 0xffffffffu;
};

/// On the calling thread.
Decoded decode(std::uint64_t ticket, std::string glb);

class Decoder {
 public:
  Decoder();
  ~Decoder();
  void submit(std::uint64_t ticket, std::string glb);
  std::vector<Decoded> poll();  ///< never waits for decoding

 private:
  void run();
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stopping_ = false;
  std::deque<std::pair<std::uint64_t, std::string>> waiting_;
  std::vector<Decoded> done_;
  std::thread thread_;
};

}  // namespace fracture::game
