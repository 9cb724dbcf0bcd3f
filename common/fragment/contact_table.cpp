#include "common/fragment/contact_table.hpp"

#include <algorithm>
#include <bit>

namespace fracture {

ContactTable::ContactTable(std::uint32_t nodes, std::size_t edges, Pacer& pacer)
    : pacer_(pacer), first_(nodes, kNone), degree_(nodes, 0) {
  node_.reserve(2 * edges);
  next_.reserve(2 * edges);
  before_.reserve(2 * edges);
  area_.reserve(edges);
  table_.assign(std::bit_ceil(2 * edges + 1), kNone);
  mask_ = table_.size() - 1;
}

void ContactTable::add(std::uint32_t a, std::uint32_t b, double area) {
  pacer_.step(16);
  std::uint32_t& edge = table_[place(a, b)];
  if (edge != kNone) {
    area_[edge] += area;
    return;
  }
  edge = static_cast<std::uint32_t>(area_.size());
  area_.push_back(area);
  for (const std::uint32_t node : {a, b}) {
    node_.push_back(node);
    next_.push_back(kNone);
    before_.push_back(kNone);
    link(static_cast<Side>(node_.size() - 1), node);
  }
}

void ContactTable::merge(std::uint32_t kept, std::uint32_t gone) {
  for (Side s = first_[gone], after = kNone; s != kNone; s = after) {
    pacer_.step(32);
    after = next_[s];
    const std::uint32_t other = node_[s ^ 1], edge = s / 2;
    forget(place(gone, other));
    unlink(s);
    std::uint32_t* known = nullptr;
    if (other != kept) known = &table_[place(kept, other)];
    if (known && *known == kNone) {
      *known = edge;
      link(s, kept);
    } else {
      if (known) area_[*known] += area_[edge];
      unlink(s ^ 1);
    }
  }
}

std::size_t ContactTable::home(std::uint32_t a, std::uint32_t b) const {
  // The finalizer of MurmurHash3 (Appleby 2011).
  std::uint64_t h = std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
  h = (h ^ h >> 33) * 0xff51afd7ed558ccdull;
  h = (h ^ h >> 33) * 0xc4ceb9fe1a85ec53ull;
  return static_cast<std::size_t>(h ^ h >> 33) & mask_;
}

std::size_t ContactTable::place(std::uint32_t a, std::uint32_t b) const {
  std::size_t at = home(a, b);
  for (; table_[at] != kNone; at = (at + 1) & mask_) {
    const std::uint32_t x = node_[2 * table_[at]], y = node_[2 * table_[at] + 1];
    if ((x == a && y == b) || (x == b && y == a)) break;
  }
  return at;
}

// Removes the entry at `place`. Later entries that had to give way to it move up (Knuth, vol. 3, 6.4,
// algorithm R).
void ContactTable::forget(std::size_t place) {
  for (std::size_t at = place;;) {
    at = (at + 1) & mask_;
    if (table_[at] == kNone) break;
    const std::size_t wanted = home(node_[2 * table_[at]], node_[2 * table_[at] + 1]);
    if (((at - wanted) & mask_) < ((at - place) & mask_)) continue;  // its home is behind `place`: it stays
    table_[place] = table_[at];
    place = at;
  }
  table_[place] = kNone;
}

void ContactTable::link(Side side, std::uint32_t node) {
  node_[side] = node;
  before_[side] = kNone;
  next_[side] = first_[node];
  if (first_[node] != kNone) before_[first_[node]] = side;
  first_[node] = side;
  ++degree_[node];
}

void ContactTable::unlink(Side side) {
  const std::uint32_t node = node_[side];
  (before_[side] != kNone ? next_[before_[side]] : first_[node]) = next_[side];
  if (next_[side] != kNone) before_[next_[side]] = before_[side];
  --degree_[node];
}

}  // namespace fracture
