// The bonds of one contact of two parts.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/structure/cell_division.hpp"
#include "common/structure/contact_bonds.hpp"
#include "common/structure/islands.hpp"

namespace fracture {

/// Divides the pieces of contacts among the cells of their parts. Each thread needs its own object. Borrows
/// all.
class ContactSharer {
 public:
  /// `wanted`: per fragment. `wanted_parts`: per part, whether any of its fragments is wanted. Both may be
  /// empty: all are wanted.
  ContactSharer(const ContactBonds& with, const FragmentsOfCells& table, const CellDivision& division,
                std::span<const Fragment* const> fragments, std::span<const char> wanted,
                std::span<const char> wanted_parts, const Execution& execution);

  /// Adds the bonds of the contact with this number.
  void share(std::uint32_t contact, std::vector<Bond>& bonds);

 private:
  /// One of the contact's two parts: the measured one, or the other.
  struct Side {
    std::uint32_t part = 0;
    const CellMap::Frame* frame = nullptr;  ///< null: the identity
    NearCells near{};                       ///< cells at the contact
    NearCells block{};                      ///< cells at a block of successive pieces
    SomeCells here{};                       ///< cells in `block` at the current piece
  };
  /// Two fragments' share of the contact.
  struct Sum {
    std::uint32_t own, other;  ///< fragment of the measured part, and of the other part
    double area = 0;           ///< m²
    double noise = 0;          ///< m²: the area that rounding may cause
    Vec3d moment{}, normal{};
  };
  /// A flat region of the surface.
  struct Region {
    double area = 0;   ///< m²
    double reach = 0;  ///< m: largest distance of a corner from the first one
    Vec3d middle;
  };
  /// A piece with derived values.
  struct Placed {
    const ContactPiece& piece;
    Vec3d across;  ///< m: from the measured surface to the other one
    Region whole;
  };

  static Vec3d image(const Side& side, const Vec3d& p) { return side.frame ? side.frame->image(p) : p; }
  static Vec3d place(const Side& side, const Vec3d& image) {
    return side.frame ? side.frame->place(image) : image;
  }
  static Region region_of(std::span<const Vec3d> corners);
  bool is_wanted(std::uint32_t fragment) const { return wanted_.empty() || wanted_[fragment]; }
  bool any_wanted(std::span<const std::uint32_t> cells) const;
  bool any_wanted_in_block() const;
  void add_whole(const Contact& contact, std::vector<Bond>& bonds) const;
  static CellBox image(const Side& side, const Box& box);
  void divide(const ContactPiece& piece, const Box& box);
  template <class Visit>
  void each_region(const Side& side, const CellPolygon& polygon, const Visit& visit);
  void divide_other(const Placed& piece, std::uint32_t own, const CellPolygon& polygon, bool is_cut);
  void add_cut(const Placed& piece, std::uint32_t own, std::uint32_t other, const CellPolygon& polygon,
               const Side& in);
  void add(const Placed& piece, std::uint32_t own, std::uint32_t other, std::span<const Vec3d> corners,
           const Region& region, bool is_cut);
  void add_whole_piece(const Placed& piece, std::uint32_t own, std::uint32_t other);
  /// Two fragments at a point of the contact.
  struct Pair {
    std::uint32_t own, other;
    friend bool operator==(const Pair&, const Pair&) = default;
  };
  Pair pick(const Placed& piece, std::uint32_t own, std::uint32_t other, const Vec3d& at);
  bool may_be_divided(const Placed& piece, std::uint32_t own, std::uint32_t other,
                      std::span<const Vec3d> corners);
  void divide_among_islands(const Placed& piece, std::uint32_t own, std::uint32_t other,
                            const std::array<Vec3d, 3>& corners, int depth);
  void add_to(const Pair& pair, const Placed& piece, const Region& region, bool is_cut);
  Sum& sum_of(std::uint32_t own, std::uint32_t other);

  const ContactBonds& with_;
  const FragmentsOfCells& table_;
  const CellDivision& division_;
  const std::span<const char> wanted_, wanted_parts_;
  const double rounding_;  ///< m
  Pacer pacer_;
  Islands islands_;
  ContactMeasure measure_{};
  bool is_one_place_ = false;  ///< both parts have the same cells, and their surfaces are in one place
  std::vector<Box> boxes_, block_boxes_;  ///< per piece, and per block of pieces
  Side own_, other_;
  CellDivision::Scratch scratch_;
  std::vector<Sum> sums_;              ///< in the order of their first pieces
  std::vector<std::uint32_t> sorted_;  ///< indices of sums, by fragments
  std::size_t last_ = 0;
};

}  // namespace fracture
