#include "common/fragment/smallest_first.hpp"

#include <algorithm>

namespace fracture {

SmallestFirst::SmallestFirst(const RestrictedDiagram& d, const Pieces& pieces, const PieceGroups& groups,
                             const std::vector<double>& volumes, const PartContacts* across,
                             std::uint32_t kept_owner, const Execution& execution)
    : SmallestFirst(pieces, groups, volumes, find_piece_contacts(d, pieces, groups.names(), execution),
                    across, kept_owner, execution) {}

SmallestFirst::SmallestFirst(const Pieces& pieces, const PieceGroups& groups,
                             const std::vector<double>& volumes, const std::vector<PieceContact>& caps,
                             const PartContacts* across, std::uint32_t kept_owner, const Execution& execution)
    : pacer_(execution),
      volume_(volumes),
      name_(pieces.pieces.size()),
      seat_(pieces.pieces.size()),
      changes_(pieces.pieces.size(), 0),
      is_kept_(pieces.pieces.size(), 0),
      caps_(static_cast<std::uint32_t>(pieces.pieces.size()), caps.size() / 2, pacer_) {
  for (std::uint32_t p = 0; p < pieces.pieces.size(); ++p) {
    pacer_.step(4);
    name_[p] = seat_[p] = p;
    if (pieces.pieces[p].owners[0] == kept_owner) is_kept_[groups.of(p)] = 1;
  }
  for (const PieceContact& c : caps)  // each pair is listed twice
    if (c.of < c.with) caps_.add(c.of, c.with, c.area);
  if (across != nullptr && !across->pieces.empty()) add_across(*across, groups);
  for (std::uint32_t p = 0; p < pieces.pieces.size(); ++p) {
    if (!groups.is_group(p)) continue;
    if (!is_kept_[p]) push(p);
    ++count_;
  }
}

void SmallestFirst::add_across(const PartContacts& across, const PieceGroups& groups) {
  across_.emplace(static_cast<std::uint32_t>(name_.size()), across.pieces.size(), pacer_);
  for (const PieceContact& c : across.pieces) {
    const std::uint32_t a = groups.of(c.of), b = groups.of(c.with);
    if (a != b) across_->add(a, b, c.area);
  }
}

bool SmallestFirst::done() {
  while (!order_.empty() && order_.front().change != changes_[order_.front().group]) pop();
  return order_.empty();
}

void SmallestFirst::leave_smallest() {
  left_.push_back(order_.front());
  pop();
}

void SmallestFirst::take_back() {
  for (const Entry& entry : left_) {
    if (entry.change != changes_[entry.group]) continue;
    pacer_.step(8);
    order_.push_back(entry);
    std::push_heap(order_.begin(), order_.end(), later);
  }
  left_.clear();
}

std::uint32_t SmallestFirst::nearest(const ContactTable& table, std::uint32_t group, bool kept) const {
  std::uint32_t with = kNoIndex;
  double area = -1;
  table.visit(seat_[group], [&](std::uint32_t other, double shared) {
    if (static_cast<bool>(is_kept_[name_[other]]) != kept) return;
    if (shared > area || (shared == area && name_[other] < with)) {
      with = name_[other];
      area = shared;
    }
  });
  return with;
}

std::uint32_t SmallestFirst::nearest(std::uint32_t group) const {
  for (const bool kept : {false, true}) {
    if (const std::uint32_t with = nearest(caps_, group, kept); with != kNoIndex) return with;
    if (!across_) continue;
    if (const std::uint32_t with = nearest(*across_, group, kept); with != kNoIndex) return with;
  }
  return kNoIndex;
}

std::size_t SmallestFirst::degree(std::uint32_t seat) const {
  return std::size_t{caps_.degree(seat)} + (across_ ? across_->degree(seat) : 0);
}

std::pair<std::uint32_t, std::uint32_t> SmallestFirst::unite_smallest() {
  const std::uint32_t g = order_.front().group;
  pop();
  const std::uint32_t with = nearest(g);
  if (with == kNoIndex) return {g, g};
  const std::uint32_t name = std::min(g, with);
  volume_[name] += volume_[std::max(g, with)];
  std::uint32_t kept = seat_[g], gone = seat_[with];
  if (degree(kept) < degree(gone)) std::swap(kept, gone);
  caps_.merge(kept, gone);
  if (across_) across_->merge(kept, gone);
  name_[kept] = name;
  seat_[name] = kept;
  ++changes_[g];
  ++changes_[with];
  is_kept_[name] = is_kept_[with];
  if (!is_kept_[name]) push(name);
  --count_;
  return {g, with};
}

void SmallestFirst::push(std::uint32_t group) {
  pacer_.step(8);
  order_.push_back({volume_[group], group, changes_[group]});
  std::push_heap(order_.begin(), order_.end(), later);
}

void SmallestFirst::pop() {
  pacer_.step(16);
  std::pop_heap(order_.begin(), order_.end(), later);
  order_.pop_back();
}

}  // namespace fracture
