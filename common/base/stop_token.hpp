// Tells a computation whether its result is still wanted. A caller passes its std::stop_token or its own type;
// code in common/ only reads it.
#pragma once

#include <concepts>
#include <functional>
#include <type_traits>
#include <utility>

namespace fracture {

/// Any copyable value with `bool stop_requested() const` that several threads may call at once.
template <class T>
concept AsksForAStop = std::copy_constructible<T> && requires(const T& token) {
  { token.stop_requested() } -> std::convertible_to<bool>;
};

class StopToken {
 public:
  StopToken() = default;  ///< never requests a stop
  // same_as is tested first, because copy_constructible<StopToken> depends on this constructor.
  template <class Token>
  requires(!std::same_as<Token, StopToken> && AsksForAStop<Token>)
      StopToken(Token token)  // implicit, so that tokens can be passed directly
      : asked_([token = std::move(token)] { return static_cast<bool>(token.stop_requested()); }) {}

  bool stop_requested() const { return asked_ && asked_(); }

 private:
  std::function<bool()> asked_;
};

}  // namespace fracture
