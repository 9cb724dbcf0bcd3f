// Typed ids. Sites, tetrahedra and vertices are all numbered from 0, and small tests do not reveal an id of
// one kind used as another kind. So each kind has its own type.
//
//   using SiteId = Id<struct SiteTag>;
//   for (const SiteId s : ids<SiteId>(site_count)) visit(points[s]);
//
// An id converts to a number implicitly: it can be printed, used as an index, and computed with. A number
// becomes an id only explicitly. Ids of different kinds cannot be compared or converted to each other.
#pragma once

#include <compare>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <type_traits>
#include <vector>

namespace fracture {

/// An index that no array has.
inline constexpr std::uint32_t kNoIndex = 0xffffffffu;

template <class Tag>
class Id {
 public:
  Id() = default;  ///< uninitialized, like a number
  template <std::integral Integer>
  constexpr explicit Id(Integer value) : value_(static_cast<std::uint32_t>(value)) {}
  constexpr operator std::uint32_t() const { return value_; }

  constexpr Id& operator++() {
    ++value_;
    return *this;
  }
  constexpr Id operator++(int) { return Id(value_++); }

  friend constexpr bool operator==(Id, Id) = default;
  friend constexpr std::strong_ordering operator<=>(Id, Id) = default;

 private:
  std::uint32_t value_;
};

// Without these, ids of two kinds would convert to numbers and compare.
template <class A, class B>
requires(!std::same_as<A, B>) bool operator==(Id<A>, Id<B>) = delete;
template <class A, class B>
requires(!std::same_as<A, B>) std::strong_ordering operator<=>(Id<A>, Id<B>) = delete;

/// The ids first, first + 1, ... end - 1; first <= end.
template <class SomeId>
class IdRange {
 public:
  class Iterator {
   public:
    constexpr explicit Iterator(std::uint32_t at) : at_(at) {}
    constexpr SomeId operator*() const { return SomeId(at_); }
    constexpr Iterator& operator++() {
      ++at_;
      return *this;
    }
    friend constexpr bool operator==(Iterator, Iterator) = default;

   private:
    std::uint32_t at_;
  };
  constexpr IdRange(std::uint32_t first, std::uint32_t end) : first_(first), end_(end) {}
  constexpr Iterator begin() const { return Iterator(first_); }
  constexpr Iterator end() const { return Iterator(end_); }

 private:
  std::uint32_t first_, end_;
};

/// All ids below `end`. For a vector: ids<SiteId>(points.size()).
template <class SomeId>
constexpr IdRange<SomeId> ids(std::size_t end) {
  return {0, static_cast<std::uint32_t>(end)};
}
/// The same as a vector.
template <class SomeId>
std::vector<SomeId> all_ids(std::size_t end) {
  std::vector<SomeId> all;
  all.reserve(end);
  for (const SomeId id : ids<SomeId>(end)) all.push_back(id);
  return all;
}
/// The ids of one block of parallel work.
template <class SomeId>
constexpr IdRange<SomeId> ids(std::size_t first, std::size_t end) {
  return {static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(end)};
}

namespace base_detail {
using AnyId = Id<struct AnyTag>;
static_assert(sizeof(AnyId) == sizeof(std::uint32_t));
static_assert(alignof(AnyId) == alignof(std::uint32_t));
static_assert(std::is_trivial_v<AnyId> && std::is_standard_layout_v<AnyId>);
}  // namespace base_detail

}  // namespace fracture

template <class Tag>
struct std::hash<fracture::Id<Tag>> {
  std::size_t operator()(fracture::Id<Tag> id) const noexcept { return std::hash<std::uint32_t>()(id); }
};
