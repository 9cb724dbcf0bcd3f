// SHA-256 of what comes piece by piece.
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
  /// Of all that came. Nothing may come after it.
  Digest finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace fracture
