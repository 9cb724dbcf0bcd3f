#include "common/contacts/contacts.hpp"

#include <algorithm>
#include <memory>

#include "common/base/pacer.hpp"
#include "common/base/work_blocks.hpp"
#include "common/contacts/part_boxes.hpp"
#include "common/contacts/part_pair.hpp"

namespace fracture {

using contacts_detail::PairMeasurer;
using contacts_detail::PartBoxes;
using contacts_detail::PartSurfaces;

ContactGraph find_contacts(const Solid& solid, double gap, const Execution& execution) {
  ContactGraph graph;
  graph.gap = gap;
  const std::size_t count = solid.parts.size();
  if (count < 2) return graph;
  const double reach = gap + contacts_detail::rounding_of(solid.box);
  const PartBoxes boxes(solid, reach, execution);
  const PartSurfaces surfaces(solid, execution);

  constexpr std::uint64_t kWorkOfTriangle = 1000, kMostWork = 4'000'000;  // ns
  const WorkBlocks blocks(execution, count, kMostWork, [&](std::size_t p) {
    return kWorkOfTriangle * surfaces.triangles_of(static_cast<std::uint32_t>(p));
  });
  struct Found {
    std::vector<Contact> contacts;
    std::vector<ContactPiece> pieces;
    std::vector<std::uint32_t> piece_counts;  // per contact
  };
  std::vector<Found> found(blocks.count());
  parallel_for_blocks(execution, blocks, [&](std::size_t block, std::size_t begin, std::size_t end) {
    PairMeasurer measurer(surfaces, gap, execution);
    Pacer steps(execution);
    std::vector<std::uint32_t> near;
    for (auto a = static_cast<std::uint32_t>(begin); a < end; ++a) {
      near.clear();
      boxes.each_near(a, steps, [&](std::uint32_t b) {
        if (b > a) near.push_back(b);
      });
      sort_with_polls(execution, near.begin(), near.end());
      Found& here = found[block];
      const std::size_t before = here.contacts.size(), all_before = here.pieces.size();
      for (const std::uint32_t b : near) {
        const std::size_t pieces_before = here.pieces.size();
        if (const auto contact = measurer.measure(a, b, here.pieces)) {
          here.contacts.push_back(*contact);
          here.piece_counts.push_back(static_cast<std::uint32_t>(here.pieces.size() - pieces_before));
        }
      }
      execution.made(Product::kContacts, here.contacts.size() - before);
      execution.made(Product::kPolygons,
                     (here.pieces.size() - all_before + 3) / 4);  // a quarter of a polygon's bytes
    }
  });
  std::size_t contacts = 0, pieces = 0;
  for (const Found& of_block : found) {
    contacts += of_block.contacts.size();
    pieces += of_block.pieces.size();
  }
  graph.contacts.reserve(contacts);
  graph.pieces.reserve(pieces);
  graph.first_piece.reserve(contacts + 1);
  graph.first_piece.push_back(0);
  for (Found& of_block : found) {
    execution.poll();
    graph.contacts.insert(graph.contacts.end(), of_block.contacts.begin(), of_block.contacts.end());
    graph.pieces.insert(graph.pieces.end(), of_block.pieces.begin(), of_block.pieces.end());
    for (const std::uint32_t more : of_block.piece_counts)
      graph.first_piece.push_back(graph.first_piece.back() + more);
    of_block = {};
  }
  return graph;
}

void keep_contacts(Solid& solid, std::optional<double> gap, const Execution& execution) {
  const double size = solid.box.longest_side();
  const double within = gap ? std::min(*gap, kMostContactGap * size) : kContactGap * size;
  solid.contacts = std::make_shared<const ContactGraph>(find_contacts(solid, within, execution));
}

}  // namespace fracture
