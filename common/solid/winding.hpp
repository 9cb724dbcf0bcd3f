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

/// The ray along +x from p (see WindingNumbers) and a triangle: +1 where it leaves through it, -1 where it
/// enters, 0 where it passes by. `clear` becomes false where p lies on the triangle and the ray's line meets
/// it.
int ray_crossing(const Vec3f& p, const std::array<Vec3f, 3>& triangle, bool& clear);

/// Rays along +x from vertices of shells, against the shells whose boxes contain the vertex: no other can
/// wind around it.
///
/// The ray from p starts at (p.x + ε³, p.y + ε, p.z + ε²), so that it meets no vertex and no edge and the
/// crossings of a closed shell sum up exactly: every sign is that of an exact orientation, and a zero is
/// decided by the first non-zero coefficient of ε, ε² (simulation of simplicity, Edelsbrunner & Mücke 1990).
///
/// Two levels of trees find the triangles that a ray can meet: the shells by their extent along the axes and
/// across the direction that most edges have (so that bars side by side are told apart however they are
/// turned), and the triangles of a large shell likewise in the plane of y and z. Memory is linear; a ray
/// costs the logarithm and the shells around its point.
class WindingNumbers {
 public:
  /// Borrows all three.
  WindingNumbers(const Surface& surface, const Shells& shells, const Execution& execution);

  struct Wind {
    std::uint32_t shell;
    int number;
  };
  /// The shells, flat ones and the shell itself excepted, that wind around shell `i`: around the first corner
  /// of its triangles that lies on no other shell (of 64 triangles; else around the last corner tried).
  /// Ascending. Valid until the next call.
  const std::vector<Wind>& around(std::uint32_t i);

  /// How often the shell winds around p, which does not lie on it.
  int number(std::uint32_t shell, const Vec3f& p);
  /// Shells and triangles that were looked at so far.
  std::uint64_t work() const { return work_; }

 private:
  static constexpr std::uint32_t kProbes = 64;
  static constexpr std::uint32_t kSmallShell = 32;  ///< triangles that are looked at one by one
  using ShellTree = StabbingTree<5>;                ///< x, y, z, and two directions across the bars
  using TriangleTree = StabbingTree<4>;  ///< y, z, across the bars in that plane, and (-∞, largest x]

  /// The triangles of one shell.
  struct Members {
    std::uint32_t asked = 0;
    Vec2d across;  ///< in the plane of y and z
    std::unique_ptr<TriangleTree> tree;
  };

  /// Shells on which a point lies: of more than two, two.
  struct Contacts {
    std::uint32_t shells[2] = {kNoIndex, kNoIndex};
    void add(std::uint32_t shell) { shells[shells[0] == kNoIndex ? 0 : 1] = shell; }
    /// On none but that one.
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
  std::vector<std::uint32_t> start_;  ///< per shell: where its triangles begin in members_
  std::vector<TriangleId> triangles_;
  double margin_ = 0;  ///< more than the rounding error of a coordinate across
  Vec3d across_[2];
  std::vector<Slabs<2>> oblique_;  ///< per shell: its extent along across_
  std::unique_ptr<ShellTree> tree_;
  std::vector<Members> large_;                 ///< shells with more than kSmallShell triangles
  std::vector<std::uint32_t> large_of_shell_;  ///< kNoIndex for small ones
  std::vector<Wind> winds_;
  std::uint64_t work_ = 0;
  /// What was found at corners that lie on several shells: corners that many shells share are tried once.
  std::map<std::array<float, 3>, Contacts> shared_;
};

}  // namespace fracture::solid_detail
