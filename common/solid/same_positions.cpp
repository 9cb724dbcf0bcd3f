#include "common/solid/same_positions.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <random>
#include <utility>

#include "common/base/pacer.hpp"

namespace fracture::solid_detail {
namespace {

/// The bits of a position, with its index.
struct BitsOfPosition {
  std::uint32_t x, y, z, index;

  BitsOfPosition() = default;
  BitsOfPosition(const Vec3f& position, std::size_t at) : index(static_cast<std::uint32_t>(at)) {
    const Vec3f p = with_one_zero(position);
    x = std::bit_cast<std::uint32_t>(p.x);
    y = std::bit_cast<std::uint32_t>(p.y);
    z = std::bit_cast<std::uint32_t>(p.z);
  }
  bool same_place(const BitsOfPosition& o) const { return x == o.x && y == o.y && z == o.z; }
};

/// Hash of positions: the folded product of two keyed halves. The keys are drawn at random once per process,
/// so that nobody can prepare positions that collide. They do not affect any answer, because among equal
/// positions the lowest index is always used.
class PositionHash {
 public:
  PositionHash() {
    static const std::array<std::uint64_t, 2> drawn = [] {
      std::random_device device;
      std::array<std::uint64_t, 2> keys;
      for (std::uint64_t& key : keys) {
        const std::uint64_t high = device();
        key = high << 32 | device();
      }
      return keys;
    }();
    keys_ = drawn;
  }
  std::uint64_t operator()(const BitsOfPosition& e) const {
    using u128 = unsigned __int128;
    const u128 product = static_cast<u128>((e.x | std::uint64_t{e.y} << 32) ^ keys_[0]) * (e.z ^ keys_[1]);
    return static_cast<std::uint64_t>(product) ^ static_cast<std::uint64_t>(product >> 64);
  }

 private:
  std::array<std::uint64_t, 2> keys_;
};

/// Entries per hash table, chosen so that its slots and entries fit into a core's own cache. There are at most
/// 2^9 tables, because writing to more places at once would wait for page-table lookups.
constexpr std::size_t kTableEntries = 16384;
constexpr int kMostTableBits = 9;
/// Number of positions distributed at once, which takes about 0.3 ms.
constexpr std::size_t kDealtAtOnce = 32768;

/// All positions, grouped by table. A radix partition before the join (Manegold, Boncz & Kersten 2002,
/// "Optimizing main-memory join on modern hardware") gives tables that fit into a cache, instead of one table
/// whose every lookup waits for memory.
class Partition {
 public:
  Partition(const std::vector<Vec3f>& positions, const Execution& execution)
      : bits_(std::min<int>(kMostTableBits, std::bit_width(positions.size() / kTableEntries))),
        start_((std::size_t{1} << bits_) + 1),
        entries_(std::make_unique_for_overwrite<BitsOfPosition[]>(positions.size())) {
    const std::size_t blocks = (positions.size() + kDealtAtOnce - 1) / kDealtAtOnce;
    // Per block and table: the number of entries, and later the position of the next one.
    std::vector<std::uint32_t> place(blocks * tables(), 0);
    const auto row = [&](std::size_t begin) { return place.data() + begin / kDealtAtOnce * tables(); };
    parallel_for(execution, positions.size(), kDealtAtOnce, [&](std::size_t begin, std::size_t end) {
      std::uint32_t* const counts = row(begin);
      for (std::size_t i = begin; i < end; ++i) ++counts[table_of(BitsOfPosition(positions[i], i))];
    });
    std::uint32_t at = 0;
    for (std::size_t table = 0; table < tables(); ++table) {
      start_[table] = at;
      for (std::size_t block = 0; block < blocks; ++block)
        at += std::exchange(place[block * tables() + table], at);
    }
    start_.back() = at;
    parallel_for(execution, positions.size(), kDealtAtOnce, [&](std::size_t begin, std::size_t end) {
      std::uint32_t* const next = row(begin);
      for (std::size_t i = begin; i < end; ++i) {
        const BitsOfPosition entry(positions[i], i);
        entries_[next[table_of(entry)]++] = entry;
      }
    });
  }

  std::size_t tables() const { return start_.size() - 1; }

  /// Finds, for each entry of a table, the lowest index with the same position.
  void look_up(std::size_t table, std::vector<std::uint32_t>& slots, std::uint32_t* first,
               const Execution& execution) const {
    const BitsOfPosition* const entries = entries_.get() + start_[table];
    const std::size_t count = start_[table + 1] - start_[table];
    const std::size_t mask = std::bit_ceil(2 * count + 1) - 1;
    slots.clear();
    resize_with_polls(execution, slots, mask + 1);
    Pacer(execution).each(0, count, [&](std::size_t i) {
      std::size_t slot = hash_(entries[i]) & mask;
      for (; slots[slot] != 0; slot = (slot + 1) & mask)
        if (entries[slots[slot] - 1].same_place(entries[i])) break;
      if (slots[slot] == 0) slots[slot] = static_cast<std::uint32_t>(i + 1);
      first[entries[i].index] = entries[slots[slot] - 1].index;
    });
  }

 private:
  std::size_t table_of(const BitsOfPosition& entry) const { return hash_(entry) >> 32 >> (32 - bits_); }

  const PositionHash hash_;
  const int bits_;
  std::vector<std::uint32_t> start_;           ///< per table: index of its first entry
  std::unique_ptr<BitsOfPosition[]> entries_;  ///< within a table, in the order of their indices
};

}  // namespace

std::unique_ptr<std::uint32_t[]> first_of_same(const std::vector<Vec3f>& positions,
                                               const Execution& execution) {
  const Partition partition(positions, execution);
  auto first = std::make_unique_for_overwrite<std::uint32_t[]>(positions.size());
  parallel_for(execution, partition.tables(), 4, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t> slots;
    for (std::size_t table = begin; table < end; ++table)
      partition.look_up(table, slots, first.get(), execution);
  });
  return first;
}

}  // namespace fracture::solid_detail
