#include "common/contacts/scenery.hpp"

#include <memory>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/contacts/contacts.hpp"

namespace fracture {
namespace {

/// Appends the parts of a solid.
void append(const Solid& more, Solid& to, Pacer& pacer) {
  const auto vertices = static_cast<std::uint32_t>(to.positions.size());
  const auto parts = static_cast<std::uint32_t>(to.parts.size());
  to.positions.insert(to.positions.end(), more.positions.begin(), more.positions.end());
  for (std::size_t t = 0; t < more.triangles.size(); ++t) {
    pacer.step(2);
    const auto& [a, b, c] = more.triangles[t];
    to.triangles.push_back({VertexId{vertices + a}, VertexId{vertices + b}, VertexId{vertices + c}});
    to.part.push_back(parts + more.part[t]);
  }
  for (const Part& part : more.parts) {
    pacer.step();
    to.parts.push_back({{}, part.volume, part.box, 0, part.node});
  }
  to.box.add(more.box);
}

/// Keeps only the contacts of parts below `first` with other parts.
ContactGraph between(const ContactGraph& all, std::uint32_t first, Pacer& pacer) {
  ContactGraph kept;
  kept.gap = all.gap;
  kept.first_piece.push_back(0);
  for (std::size_t k = 0; k < all.contacts.size(); ++k) {
    pacer.step();
    const Contact& c = all.contacts[k];  // a < b
    if (c.a >= first || c.b < first) continue;
    kept.contacts.push_back(c);
    kept.pieces.insert(kept.pieces.end(), all.pieces.begin() + all.first_piece[k],
                       all.pieces.begin() + all.first_piece[k + 1]);
    kept.first_piece.push_back(static_cast<std::uint32_t>(kept.pieces.size()));
  }
  return kept;
}

}  // namespace

void keep_scenery(Solid& solid, const SolidOptions& options, const Execution& execution) {
  solid.scenery = nullptr;
  if (!solid.source->passed_through || !solid.contacts) return;
  SolidOptions filled = options;
  filled.repair = Repair::kFill;
  if (filled.sheets != SheetsMode::kSolid && !(filled.thickness > 0)) filled.sheets = SheetsMode::kDrop;
  const Expected<Solid> rest = make_solid(solid.source->passed_through, filled, execution);
  if (!rest) return;
  Pacer pacer(execution);
  auto made = std::make_shared<Scenery>();
  append(solid, made->both, pacer);
  append(*rest, made->both, pacer);
  const ContactGraph all = find_contacts(made->both, solid.contacts->gap, execution);
  made->both.contacts = std::make_shared<const ContactGraph>(
      between(all, static_cast<std::uint32_t>(solid.parts.size()), pacer));
  for (const Part& part : rest->parts) made->node_of_part.push_back(part.node);
  solid.scenery = std::move(made);
}

}  // namespace fracture
