#include "common/contacts/contact_report.hpp"

#include <algorithm>
#include <tuple>

namespace fracture {

std::optional<ContactReport> contact_report(const Solid& solid) {
  if (!solid.contacts || solid.parts.size() < 2) return std::nullopt;
  const std::vector<Contact>& contacts = solid.contacts->contacts;
  ContactReport report{.gap = solid.contacts->gap, .parts = solid.parts.size(), .pairs = contacts.size()};
  std::vector<char> held(solid.parts.size(), 0);
  for (const Contact& c : contacts) {
    ++(c.kind == ContactKind::kTouching ? report.touching : report.overlapping);
    report.area += c.area;
    report.volume += c.volume;
    if (c.area > 0) held[c.a] = held[c.b] = 1;
  }
  report.alone = static_cast<std::uint64_t>(std::count(held.begin(), held.end(), 0));
  report.listed.resize(std::min(contacts.size(), kMostListedContacts));
  std::partial_sort_copy(contacts.begin(), contacts.end(), report.listed.begin(), report.listed.end(),
                         [](const Contact& x, const Contact& y) {
                           return std::tuple(-x.area, x.a, x.b) < std::tuple(-y.area, y.a, y.b);
                         });
  return report;
}

}  // namespace fracture
