// Whether somebody still wants what is being computed. The server answers with a std::stop_token, a module in
// a page with a flag: what stands in common/ only asks.
#pragma once

#include <concepts>
#include <functional>
#include <type_traits>
#include <utility>

namespace fracture {

/// Any copyable value with `bool stop_requested() const` that several threads may ask at once.
template <class T>
concept AsksForAStop = std::copy_constructible<T> && requires(const T& token) {
  { token.stop_requested() } -> std::convertible_to<bool>;
};

class StopToken {
 public:
  StopToken() = default;  ///< nobody ever asks for a stop
  // Whether it is itself is asked first: whether StopToken can be copied depends on the answer.
  template <class Token>
  requires(!std::same_as<Token, StopToken> && AsksForAStop<Token>)
      StopToken(Token token)  // NOLINT(google-explicit-constructor): a token is passed as what it is
      : asked_([token = std::move(token)] { return static_cast<bool>(token.stop_requested()); }) {}

  bool stop_requested() const { return asked_ && asked_(); }

 private:
  std::function<bool()> asked_;
};

}  // namespace fracture
