// Binds a row of the parameter table to a member of RequestParameters. A single accessor yields the setter and the canonical form.
#pragma once

#include <optional>
#include <type_traits>
#include <utility>

#include "common/parameters/parameters.hpp"

namespace fracture::parameter_fields {

inline constexpr double kFar = 1e6;  ///< metres: the largest length
inline constexpr double kFarPlace =
    1e8;  ///< metres: the largest coordinate of a place in a file; planets have less
inline constexpr double kLeastLength = 1e-6;  ///< metres
/// Matrix rows or slice normals that are closer to linear dependence than this have no usable inverse.
inline constexpr double kLeastConditioning = 1e-3;

template <class T>
void assign(T& to, const ParameterValue& value) {
  if constexpr (std::is_enum_v<T> || std::is_integral_v<T>)
    to = static_cast<T>(std::get<std::uint64_t>(value));
  else
    to = std::get<T>(value);
}
template <class T>
void assign(std::optional<T>& to, const ParameterValue& value) {
  assign(to.emplace(), value);
}

inline nlohmann::json to_json(const Vec3d& v) { return {v.x, v.y, v.z}; }

/// Returns the JSON value; null if the value is empty or not set.
template <class T>
nlohmann::json shown_as(const T& value, const ParameterSpec& spec) {
  if constexpr (std::is_enum_v<T>) {
    return spec.choices.at(static_cast<std::size_t>(value));
  } else if constexpr (std::is_same_v<T, Vec3d>) {
    return to_json(value);
  } else if constexpr (std::is_same_v<T, Matrix3>) {
    return {to_json(value.rows[0]), to_json(value.rows[1]), to_json(value.rows[2])};
  } else if constexpr (std::is_same_v<T, std::vector<Vec3d>>) {
    nlohmann::json list;
    for (const Vec3d& v : value) list.push_back(to_json(v));
    return list;
  } else if constexpr (requires { value.empty(); }) {
    return value.empty() ? nlohmann::json() : nlohmann::json(value);
  } else {
    return value;
  }
}
template <class T>
nlohmann::json shown_as(const std::optional<T>& value, const ParameterSpec& spec) {
  return value ? shown_as(*value, spec) : nlohmann::json();
}

/// `member` is a generic lambda: [](auto& request) -> auto& { return request.fracture.seed; }
template <class Member>
ParameterSpec with_member(ParameterSpec spec, Member member) {
  spec.set = [member](RequestParameters& r, const ParameterSpec&, const ParameterValue& value) {
    assign(member(r), value);
  };
  spec.get = [member](const RequestParameters& r, const ParameterSpec& s) { return shown_as(member(r), s); };
  return spec;
}

template <class Pattern, class Value>
Pattern pattern_of_member(Value Pattern::*);
template <auto member>
using PatternOf = decltype(pattern_of_member(member));

template <class Pattern>
std::string pattern_name() {
  return kPatternTraits[SitePattern(Pattern{}).index()].name;
}

/// Makes a parameter of the patterns that own `members`. `get` is called only if the request uses one of
/// these patterns.
template <auto... members>
ParameterSpec with_pattern_member(ParameterSpec spec) {
  spec.decides = Decides::kSites;
  spec.patterns = {pattern_name<PatternOf<members>>()...};
  spec.set = [](RequestParameters& r, const ParameterSpec&, const ParameterValue& value) {
    const auto set_if = [&]<auto member>() {
      if (auto* pattern = std::get_if<PatternOf<member>>(&r.fracture.pattern))
        assign(pattern->*member, value);
    };
    (set_if.template operator()<members>(), ...);
  };
  spec.get = [](const RequestParameters& r, const ParameterSpec& s) {
    nlohmann::json result;
    const auto get_if = [&]<auto member>() {
      if (const auto* pattern = std::get_if<PatternOf<member>>(&r.fracture.pattern))
        result = shown_as(pattern->*member, s);
    };
    (get_if.template operator()<members>(), ...);
    return result;
  };
  return spec;
}

}  // namespace fracture::parameter_fields
