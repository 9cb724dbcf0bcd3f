// Winding numbers of shells around a point.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/pacer.hpp"
#include "common/solid/shells.hpp"
#include "common/solid/stabbing_tree.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// How the ray along +x from p (see WindingNumbers) crosses a triangle: +1 if it leaves through it, -1 if it
/// enters, 0 if it misses. `clear` becomes false if p is on the triangle and the ray's line meets it.
int ray_crossing(const Vec3f& p, const std::array<Vec3f, 3>& triangle, bool& clear);

/// Casts rays along +x from vertices of shells. Tests only the shells whose boxes contain the vertex, because
/// no other shell can wind around it.
///
/// The ray from p starts at (p.x + ε³, p.y + ε, p.z + ε²). So it meets no vertex and no edge, and the
/// crossings of a closed shell sum up exactly. Every sign is that of an exact orientation, and a zero is
/// resolved by the first non-zero coefficient of ε, ε² (simulation of simplicity, Edelsbrunner & Mücke 1990).
///
/// Two levels of trees find the triangles that a ray can meet. The first level has the shells, by their
/// extent along the axes and perpendicular to the most common edge direction (so that parallel bars are
/// separated in any orientation). The second level has the triangles of each large shell, likewise, in the
/// plane of y and z. Memory is linear. The cost of a ray is logarithmic, plus the shells around its point.
class WindingNumbers {
 public:
  /// Borrows all three arguments.
  WindingNumbers(const Surface& surface, const Shells& shells, const Execution& execution);

  struct Wind {
    std::uint32_t shell;
    int number;
  };
  /// Returns the shells that wind around shell `i`, except flat ones and itself. Uses the first corner of its
  /// triangles that is on no other shell (among 64 triangles; otherwise, the last corner tried). Ascending.
  /// Valid until the next call.
  const std::vector<Wind>& around(std::uint32_t i);

  /// Winding number of the shell around p, which must not be on the shell.
  int number(std::uint32_t shell, const Vec3f& p);
  /// Number of shells and triangles tested so far.
  std::uint64_t work() const { return work_; }

 private:
  static constexpr std::uint32_t kProbes = 64;
  static constexpr std::uint32_t kSmallShell = 32;  ///< up to this many triangles are tested one by one
  using ShellTree = StabbingTree<5>;                ///< x, y, z, and two directions across the bars
  using TriangleTree = StabbingTree<4>;  ///< y, z, across the bars in that plane, and (-∞, largest x]

  /// The triangles of one shell.
  struct Members {
    std::uint32_t asked = 0;
    Vec2d across;  ///< in the plane of y and z
    std::unique_ptr<TriangleTree> tree;
  };

  /// Shells that contain a point on their surface; only two of them if there are more.
  struct Contacts {
    std::uint32_t shells[2] = {kNoIndex, kNoIndex};
    void add(std::uint32_t shell) { shells[shells[0] == kNoIndex ? 0 : 1] = shell; }
    /// Whether the point is on no other shell.
    bool clear_of(std::uint32_t self) const {
      return (shells[0] == kNoIndex || shells[0] == self) && (shells[1] == kNoIndex || shells[1] == self);
    }
  };

  Contacts cast(const Vec3f& p, std::uint32_t self);
  int crossings(const Vec3f& p, std::uint32_t shell, bool& clear);
  int crossing(const Vec3f& p, TriangleId t, bool& clear);
  void plant(std::uint32_t shell, Members& members);
  Slabs<5> shell_slabs(std::uint32_t shell) const;

  const Surface& surface_;
  const Shells& shells_;
  Pacer pacer_;
  std::vector<std::uint32_t> start_;  ///< per shell: index of its first triangle in triangles_
  std::vector<TriangleId> triangles_;
  double margin_ = 0;  ///< exceeds the rounding error of a coordinate along across_
  Vec3d across_[2];
  std::vector<Slabs<2>> oblique_;  ///< per shell: its extent along across_
  std::unique_ptr<ShellTree> tree_;
  std::vector<Members> large_;                 ///< shells with more than kSmallShell triangles
  std::vector<std::uint32_t> large_of_shell_;  ///< kNoIndex for small shells
  std::vector<Wind> winds_;
  std::uint64_t work_ = 0;
  /// Results at corners that are on several shells, so that shared corners are tried only once.
  std::map<std::array<float, 3>, Contacts> shared_;
};

}  // namespace fracture::solid_detail
