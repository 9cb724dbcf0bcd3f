// SHA-256 of data that arrives in pieces.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "common/digest/digest.hpp"

namespace fracture {

class RunningDigest {
 public:
  RunningDigest();
  ~RunningDigest();
  RunningDigest(RunningDigest&&) noexcept;
  RunningDigest& operator=(RunningDigest&&) noexcept;

  void add(std::span<const std::byte> bytes);
  /// Returns the digest of all pieces. add() must not be called afterwards.
  Digest finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace fracture
