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
  static constexpr std::uint32_t kNoFragment = 0xffffffffu;
  /// What one answer brought to be seen: first the whole, then what each hit changed of it.
  struct Layer {
    std::shared_ptr<const render::Model> model;
    std::vector<std::uint32_t>
        fragment_of_object;  ///< per object of the model; kNoFragment for what is not seen
  };
  std::uint64_t ticket = 0;
  std::string error;  ///< for people: what is wrong with the file, where `fragments` is null; else empty
  std::shared_ptr<const std::string> glb;  ///< as it came
  std::shared_ptr<const world::PreparedFragments> fragments;
  std::vector<Layer> layers;
  std::string location;  ///< of the answer, which the next hit names; empty where the server said none
};

/// On the calling thread. `before`: of an answer that has what a hit changed of this; null for a whole one.
Decoded decode(std::uint64_t ticket, std::string glb, const std::shared_ptr<const Decoded>& before = nullptr);

class Decoder {
 public:
  Decoder();
  ~Decoder();
  void submit(std::uint64_t ticket, std::string glb, std::shared_ptr<const Decoded> before = nullptr);
  std::vector<Decoded> poll();  ///< never waits for decoding

 private:
  void run();

  std::mutex mutex_;
  std::condition_variable wake_;
  bool stopping_ = false;
  struct Job {
    std::uint64_t ticket;
    std::string glb;
    std::shared_ptr<const Decoded> before;
  };
  std::deque<Job> waiting_;
  std::vector<Decoded> done_;
  std::thread thread_;
};

}  // namespace fracture::game
