#include "common/solid/part_solid.hpp"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/solid/patch.hpp"

namespace fracture {
namespace {

/// Returns the contacts among the chosen parts. `new_part`: per part of the whole, its new number or kNoIndex.
std::shared_ptr<const ContactGraph> contacts_among(const ContactGraph& whole,
                                                   const std::vector<std::uint32_t>& new_part, Pacer& pacer) {
  auto made = std::make_shared<ContactGraph>();
  made->gap = whole.gap;
  for (std::size_t k = 0; k < whole.contacts.size(); ++k) {
    pacer.step();
    Contact contact = whole.contacts[k];
    if (new_part[contact.a] == kNoIndex || new_part[contact.b] == kNoIndex) continue;
    contact.a = new_part[contact.a];
    contact.b = new_part[contact.b];
    made->contacts.push_back(contact);
    made->first_piece.push_back(static_cast<std::uint32_t>(made->pieces.size()));
    const auto begin = whole.pieces.begin() + whole.first_piece[k],
               end = whole.pieces.begin() + whole.first_piece[k + 1];
    pacer.step(static_cast<std::uint64_t>(end - begin));
    made->pieces.insert(made->pieces.end(), begin, end);
  }
  made->first_piece.push_back(static_cast<std::uint32_t>(made->pieces.size()));
  return made;
}

}  // namespace

Solid solid_of_parts(const Solid& whole, std::span<const std::uint32_t> parts, const Execution& execution) {
  Pacer pacer(execution);
  std::vector<std::uint32_t> new_part(whole.parts.size(), kNoIndex), triangles;
  for (std::size_t k = 0; k < parts.size(); ++k) new_part[parts[k]] = static_cast<std::uint32_t>(k);
  for (std::uint32_t t = 0; t < whole.triangles.size(); ++t) {
    pacer.step();
    if (new_part[whole.part[t]] != kNoIndex) triangles.push_back(t);
  }
  Solid solid = std::move(patch_of(whole, std::move(triangles), parts, execution).solid);

  // A patch has no shells, box and report of its own.
  std::vector<std::uint32_t> shells;  // numbers in the whole, ascending
  SolidReport& report = solid.report;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const Part& part = whole.parts[parts[k]];
    Part& own = solid.parts[k];
    own.shells = part.shells;
    own.color = part.color;
    own.translucent = part.translucent;
    shells.insert(shells.end(), part.shells.begin(), part.shells.end());
    report.volume += part.volume;
    report.cavities += part.shells.size() - 1;
  }
  sort_with_polls(execution, shells.begin(), shells.end());
  const auto new_shell = [&](std::uint32_t shell) {
    pacer.step();
    return static_cast<std::uint32_t>(std::lower_bound(shells.begin(), shells.end(), shell) - shells.begin());
  };
  for (Part& part : solid.parts)
    for (std::uint32_t& shell : part.shells) shell = new_shell(shell);
  for (std::uint32_t& shell : solid.shell) shell = new_shell(shell);
  solid.box = {};
  for (const Vec3f& p : solid.positions) {
    pacer.step();
    solid.box.add(to_double(p));
  }
  for (const auto& [a, b, c] : solid.triangles) {
    pacer.step(4);
    const Vec3d corner = to_double(solid.positions[a]);
    report.area +=
        0.5 * length(cross(to_double(solid.positions[b]) - corner, to_double(solid.positions[c]) - corner));
  }
  report.parts = parts.size();
  report.shells = shells.size();
  // Bounds rounding errors. Shells of other parts have at least the volumes of these parts.
  report.absolute_volume = whole.report.absolute_volume - (whole.report.volume - report.volume);
  if (whole.contacts) solid.contacts = contacts_among(*whole.contacts, new_part, pacer);
  return solid;
}

}  // namespace fracture
