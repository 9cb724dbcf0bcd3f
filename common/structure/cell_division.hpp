// Divides convex polygons among the cells that they meet, in doubles: only areas must be right, not topology.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/structure/fragments_of_cells.hpp"
#include "common/voronoi/site_tree.hpp"

namespace fracture {

/// A polygon in the image under the cells' map. Copying copies only the corners in use.
class CellPolygon {
 public:
  static constexpr std::size_t kMost = 32;  ///< maximum number of corners; further corners are left out

  CellPolygon() {}
  CellPolygon(const CellPolygon& from) { *this = from; }
  CellPolygon& operator=(const CellPolygon& from) {
    size_ = from.size_;
    std::copy_n(from.corners_.begin(), size_, corners_.begin());
    return *this;
  }
  std::size_t size() const { return size_; }
  Vec3d corner(std::size_t k) const { return {corners_[k].x, corners_[k].y, corners_[k].z}; }
  /// Returns the cell beyond the edge from corner k to the next; kNoSite if there is none.
  SiteId beyond(std::size_t k) const { return corners_[k].beyond; }
  void push(const Vec3d& p, SiteId beyond) {
    if (size_ < kMost) corners_[size_++] = {p.x, p.y, p.z, beyond};
  }
  void clear() { size_ = 0; }

 private:
  struct Corner {
    double x, y, z;
    SiteId beyond;
  };
  std::array<Corner, kMost> corners_;
  std::size_t size_ = 0;
};

/// A box in the image: all points at most `half` away from the centre along each axis.
struct CellBox {
  Vec3d center, half;
};

/// Cells of a part that may contain a part of a region.
struct NearCells {
  std::vector<std::uint32_t> cells;  ///< ascending
  std::vector<SiteId> sites;         ///< per cell
  std::vector<Vec3d> points;         ///< per cell
  void clear() {
    cells.clear();
    sites.clear();
    points.clear();
  }
  void push(std::uint32_t cell, SiteId site, const Vec3d& point) {
    cells.push_back(cell);
    sites.push_back(site);
    points.push_back(point);
  }
  std::size_t size() const { return cells.size(); }
};
/// A subset of NearCells.
struct SomeCells {
  std::vector<std::uint32_t> places;  ///< in NearCells, ascending
  std::uint32_t nearest = 0;          ///< place of the cell whose site is nearest to the region's middle
};

/// Divides polygons. Borrows the table and the points.
class CellDivision {
 public:
  /// `points`: the image of each site. `has_many`: whether a part has many cells, so that a tree of the
  /// points is built.
  CellDivision(const FragmentsOfCells& table, std::span<const Vec3d> points, bool has_many);
  static constexpr std::uint32_t kMany = 64;

  /// Working memory for reuse.
  struct Scratch {
    NearCells among{};
    SomeCells some{};
  };
  /// Finds the part's cells that may contain a point of the box; at least one if the part has any.
  void near(std::uint32_t part, const CellBox& box, Scratch& scratch, NearCells& cells) const;
  /// Finds the cells in `among` that may contain a point of the box.
  static void near_of(const NearCells& among, const CellBox& box, SomeCells& some);
  static void near_of(const NearCells& among, const CellBox& box, Scratch& scratch, NearCells& cells);

  /// Computes the part of a polygon in the cell at `place` in `near`. `some`: places of all cells that may
  /// contain a part of the polygon, including this one. The region's bits depend only on the cells that
  /// bound it. Returns whether the region is smaller than the polygon; it may be empty.
  bool region(std::uint32_t place, const NearCells& near, std::span<const std::uint32_t> some,
              const CellPolygon& whole, CellPolygon& region) const;

 private:
  bool cut(CellPolygon& polygon, SiteId keep, SiteId other) const {
    return cut(polygon, keep, points_[keep], other, points_[other]);
  }
  static bool cut(CellPolygon& polygon, SiteId keep, const Vec3d& keep_point, SiteId other,
                  const Vec3d& other_point);

  const FragmentsOfCells& table_;
  const std::span<const Vec3d> points_;
  std::optional<SiteTree> tree_;
};

}  // namespace fracture
