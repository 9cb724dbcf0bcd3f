// Decodes GLB answers on a separate thread, so that a frame gets finished collision shapes and vertices.
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
  /// The visible parts from one answer: the first layer is the whole, and each further hit adds a layer of
  /// changes.
  struct Layer {
    std::shared_ptr<const render::Model> model;
    std::vector<std::uint32_t>
        fragment_of_object;  ///< per object of the model; kNoFragment if it is not visible
  };
  std::uint64_t ticket = 0;
  std::string error;  ///< if `fragments` is null: what is wrong with the file, for people
  std::shared_ptr<const std::string> glb;  ///< as received
  std::shared_ptr<const world::PreparedFragments> fragments;
  std::vector<Layer> layers;
  std::string location;  ///< the answer's address, which the next hit states; empty if unknown
};

/// Runs on the calling thread. `before`: the answer that this one changes after a hit; null for a complete
/// answer.
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
