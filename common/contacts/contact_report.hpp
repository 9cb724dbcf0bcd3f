// Statistics about the contacts of a solid's parts, for a report.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/solid/contact_graph.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

struct ContactReport {
  double gap = 0;           ///< m
  std::uint64_t parts = 0;  ///< number of parts of the solid
  std::uint64_t alone = 0;  ///< parts that have no contact with an area, so nothing holds them
  std::uint64_t pairs = 0;  ///< number of contacts
  std::uint64_t touching = 0, overlapping = 0;  ///< numbers of contacts of each kind
  double area = 0;                              ///< m², sum over all contacts
  double volume = 0;  ///< m³ that pairs of parts have in common; space in three parts counts three times
  /// The kMostListedContacts with the largest areas, largest first; ties by a and b
  std::vector<Contact> listed{};
  bool operator==(const ContactReport&) const = default;
};

inline constexpr std::size_t kMostListedContacts = 100;

/// Returns the statistics; nothing if the solid has only one part, or if its contacts were not searched
/// for.
std::optional<ContactReport> contact_report(const Solid& solid);

}  // namespace fracture
