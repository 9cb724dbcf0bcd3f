#include "tests/support/growth_families.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/random.hpp"
#include "tests/support/assemble.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

std::uint32_t add(Mesh& mesh, const Vec3d& p) {
  mesh.positions.push_back(to_float(p));
  return static_cast<std::uint32_t>(mesh.positions.size() - 1);
}
double between(Random& random, double low, double high) {
  const double u = random.uniform();
  return low + u * (high - low);
}
Vec3d point_in(Random& random, const Vec3d& low, const Vec3d& high) {
  Vec3d p;
  for (int a = 0; a < 3; ++a) p[a] = between(random, low[a], high[a]);
  return p;
}
/// The largest r with r * r <= n.
int root_of(std::uint32_t n) {
  int r = static_cast<int>(std::sqrt(static_cast<double>(n)));
  while (static_cast<std::uint32_t>((r + 1) * (r + 1)) <= n) ++r;
  return std::max(r, 1);
}
/// Two sites whose bisector is the plane through `middle` with this normal.
std::vector<Vec3d> cut_once(const Vec3d& middle, const Vec3d& normal) {
  return {middle - 0.25 * normal, middle + 0.25 * normal};
}

// A thin pane of 12 triangles: every cell cuts the same two faces.
GrowthInput pane(std::uint32_t n, std::uint64_t) { return {box({0, 0, 0}, {1, 1, 0.001}), {}, n}; }

// One closed comb, a bar with n teeth. One plane cuts all teeth, in n regions of one cap.
GrowthInput comb(std::uint32_t n, std::uint64_t) {
  Mesh mesh;
  const auto teeth = static_cast<int>(std::max(n, 1u));
  // The points for each x: the bottom of the bar, its top, and the end of a tooth. Each occurs in front (z =
  // 0) and behind.
  const int columns = 2 * teeth;
  const double pitch = 10.0 / columns;
  for (int c = 0; c < columns; ++c)
    for (const double z : {0.0, 1.0})
      for (const double y : {0.0, 1.0, 3.0}) add(mesh, {c * pitch, y, z});
  const auto at = [](int c, int z, int y) { return static_cast<std::uint32_t>(6 * c + 3 * z + y); };
  const auto slab = [&](int c, int low, int high) {  // the front and the back of one quad of the outline
    add_quad(mesh, at(c, 1, low), at(c + 1, 1, low), at(c + 1, 1, high), at(c, 1, high));
    add_quad(mesh, at(c, 0, low), at(c, 0, high), at(c + 1, 0, high), at(c + 1, 0, low));
  };
  const auto wall = [&](int c, int y, int d,
                        int w) {  // the edge from (c, y) to (d, w), inside at its left
    add_quad(mesh, at(c, 0, y), at(d, 0, w), at(d, 1, w), at(c, 1, y));
  };
  for (int c = 0; c + 1 < columns; ++c) {
    slab(c, 0, 1);
    wall(c, 0, c + 1, 0);
    if (c % 2 == 1) {
      wall(c + 1, 1, c, 1);
      continue;
    }
    slab(c, 1, 2);
    wall(c + 1, 1, c + 1, 2);
    wall(c + 1, 2, c, 2);
    wall(c, 2, c, 1);
  }
  wall(columns - 1, 0, columns - 1, 1);
  wall(0, 1, 0, 0);
  finish(mesh, "growth");
  return {mesh, cut_once({5, 2, 0.5}, {0, 1, 0}), 0};
}

// A wall of n bricks that do not touch. It faces x, so the boxes of all bricks overlap along x.
GrowthInput bricks(std::uint32_t n, std::uint64_t) {
  const int columns = root_of(n);
  std::vector<Mesh> all;
  for (std::uint32_t k = 0; k < n; ++k) {
    const auto z = static_cast<double>(k % static_cast<std::uint32_t>(columns)),
               y = static_cast<double>(k / static_cast<std::uint32_t>(columns));
    all.push_back(box({0, 0.5 * y, z}, {0.45, 0.5 * y + 0.4, z + 0.9}));
  }
  return {joined(all), {}, 100};
}

// n long bars along the diagonal, with boxes that all overlap. There are ten sites for each bar in one plane
// across them. So each bar meets a few cells, however many there are.
GrowthInput bars(std::uint32_t n, std::uint64_t seed) {
  Random random(seed);
  const Vec3d u{1 / std::sqrt(2.0), -1 / std::sqrt(2.0), 0},
      v{1 / std::sqrt(6.0), 1 / std::sqrt(6.0), -2 / std::sqrt(6.0)}, w{1, 1, 1};
  const int side = root_of(n) + 1;
  const double pitch = 1.0 / side, width = 0.25 * pitch;
  std::vector<Mesh> all;
  for (std::uint32_t k = 0; k < n; ++k) {
    const double x = (k % static_cast<std::uint32_t>(side)) * pitch,
                 y = (k / static_cast<std::uint32_t>(side)) * pitch;
    all.push_back(parallelepiped(x * u + y * v, width * u, width * v, 2 * w));
  }
  GrowthInput input{joined(all), {}, 0};
  for (std::uint32_t k = 0; k < 10 * n; ++k) {
    const double x = random.uniform(), y = random.uniform();
    input.sites.push_back(x * u + y * v + w);
  }
  return input;
}

// A sphere of 10 n triangles with one site in its middle and n around it. Each of their bisectors cuts off a
// small cap.
GrowthInput hub(std::uint32_t n, std::uint64_t seed) {
  Random random(seed);
  GrowthInput input{sphere_with(static_cast<int>(std::max(10 * n, 60u))), {{0, 0, 0}}, 0};
  // A cap of height 1/n has half the area available to each of n caps.
  const double distance = 2 * (1 - 1.0 / std::max(n, 4u));
  while (input.sites.size() <= n) {
    const Vec3d p = point_in(random, {-1, -1, -1}, {1, 1, 1});
    const double l = length(p);
    if (l > 0.1 && l <= 1) input.sites.push_back((distance / l) * p);
  }
  return input;
}

// A prism over a Lissajous curve of n points, cut across. The loop of the cap crosses itself dozens of times.
// A circle is added, because the curve alone turns equally often in both directions.
GrowthInput lissajous(std::uint32_t n, std::uint64_t) {
  std::vector<Vec2d> polygon;
  const auto count = static_cast<std::int64_t>(std::max(n, 8u));
  for (std::int64_t k = 0; k < count; ++k) {
    const CirclePoint circle = circle_point(k, count);
    polygon.push_back(
        {circle_point(5 * k, count).cos + circle.cos, circle_point(7 * k, count).sin + circle.sin});
  }
  return {prism_over(polygon), cut_once({0, 0, 0.5}, {0, 0, 1}), 0};
}

// The same over a polygon with random corners. Each of its edges crosses a third of the others.
GrowthInput scribble(std::uint32_t n, std::uint64_t seed) {
  Random random(seed);
  std::vector<Vec2d> polygon;
  for (std::uint32_t k = 0; k < std::max(n, 3u); ++k) {
    const double x = random.uniform(), y = random.uniform();
    polygon.push_back({x, y});
  }
  return {prism_over(polygon), cut_once({0.5, 0.5, 0.5}, {0, 0, 1}), 0};
}

// n thin boxes along (0, 1, 1), whose projections along any axis overlap, and one inverted cube.
GrowthInput thin_boxes(std::uint32_t n, std::uint64_t) {
  std::vector<Mesh> all{translated(inside_out_cube(), {-2, 0.5, 0.5})};
  const double pitch = 1.0 / std::max(n, 1u), width = 0.25 * pitch;
  for (std::uint32_t k = 0; k < n; ++k)
    all.push_back(parallelepiped({0, k * pitch, 0}, {1, 0, 0}, {0, width, 0}, {0, 1, 1}));
  return {joined(all), {}, 2};
}

// n nested boxes, alternately outward and inward: n / 2 parts with a cavity each, cut through the middle.
GrowthInput matryoshka(std::uint32_t n, std::uint64_t) {
  std::vector<Mesh> all;
  for (std::uint32_t k = 0; k < std::max(n, 1u); ++k) {
    const double r = 1 - 0.9 * k / std::max(n, 1u);
    Mesh shell = box({-r, -r, -r}, {r, r, r});
    all.push_back(k % 2 == 0 ? std::move(shell) : reversed(std::move(shell)));
  }
  return {joined(all), cut_once({0, 0, 0.01}, {0, 0, 1}), 0};
}

// n thin tetrahedra around one edge that all of them use.
GrowthInput fan(std::uint32_t n, std::uint64_t) {
  Mesh mesh;
  const std::uint32_t low = add(mesh, {0, 0, 0}), high = add(mesh, {0, 0, 1});
  const auto count = static_cast<std::int64_t>(std::max(n, 2u));
  for (std::int64_t k = 0; k < count; ++k) {
    const CirclePoint a = circle_point(2 * k, 2 * count), b = circle_point(2 * k + 1, 2 * count);
    const std::uint32_t p = add(mesh, {a.cos, a.sin, 0.5}), q = add(mesh, {b.cos, b.sin, 0.5});
    mesh.triangles.insert(mesh.triangles.end(), {{low, p, high}, {low, high, q}, {low, q, p}, {high, p, q}});
  }
  finish(mesh, "growth");
  return {mesh, {}, 20};
}

// A cube of 24 n squares. n squares are missing, and no two of these are neighbours.
GrowthInput holes(std::uint32_t n, std::uint64_t) {
  const int side = std::max(2 * root_of(std::max(n / 6, 1u)), 2);
  Mesh mesh = box({0, 0, 0}, {1, 1, 1}, side);
  // box() adds two triangles per square, row by row and face by face.
  std::vector<std::array<std::uint32_t, 3>> kept;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::size_t square = t / 2 % static_cast<std::size_t>(side * side),
                      row = square / static_cast<std::size_t>(side),
                      column = square % static_cast<std::size_t>(side);
    if (row % 2 == 0 || column % 2 == 0) kept.push_back(mesh.triangles[t]);
  }
  mesh.triangles = std::move(kept);
  finish(mesh, "growth");
  return {mesh, {}, 20};
}

// A box with n cavities. Cuts meet few of them.
GrowthInput cavities(std::uint32_t n, std::uint64_t) {
  int side = 1;
  while (static_cast<std::uint32_t>(side * side * side) < n) ++side;
  const auto s = static_cast<double>(side);
  std::vector<Mesh> all{box({0, 0, 0}, {s, s, s})};
  for (std::uint32_t k = 0; k < n; ++k) {
    const auto m = static_cast<std::uint32_t>(side);
    const double x = k % m, y = k / m % m, z = k / m / m;
    all.push_back(reversed(box({x + 0.3, y + 0.3, z + 0.3}, {x + 0.7, y + 0.7, z + 0.7})));
  }
  return {joined(all), cut_once({s / 2, s / 2, s / 2}, {0, 0, s}), 0};
}

// A double cone: n triangles at each of its two tips.
GrowthInput umbrella(std::uint32_t n, std::uint64_t) {
  Mesh mesh;
  const std::uint32_t low = add(mesh, {0, 0, -1}), high = add(mesh, {0, 0, 1});
  const auto count = static_cast<std::uint32_t>(std::max(n, 3u));
  for (std::uint32_t k = 0; k < count; ++k) {
    const CirclePoint c = circle_point(k, count);
    add(mesh, {c.cos, c.sin, 0});
  }
  for (std::uint32_t k = 0; k < count; ++k) {
    const std::uint32_t a = 2 + k, b = 2 + (k + 1) % count;
    mesh.triangles.insert(mesh.triangles.end(), {{high, a, b}, {low, b, a}});
  }
  finish(mesh, "growth");
  return {mesh, {}, 10};
}

// A long prism with n sides, cut fifty times. All its triangles are as long as the prism.
GrowthInput needles(std::uint32_t n, std::uint64_t seed) {
  Random random(seed);
  std::vector<Vec2d> polygon;
  const auto count = static_cast<std::int64_t>(std::max(n, 3u));
  for (std::int64_t k = 0; k < count; ++k) {
    const CirclePoint c = circle_point(k, count);
    polygon.push_back({c.cos, c.sin});
  }
  GrowthInput input{scaled(prism_over(polygon), {1, 1, 100}), {}, 0};
  for (int k = 0; k < 50; ++k) {
    const double z = random.uniform();
    input.sites.push_back({0, 0, 2 * k + z});
  }
  return input;
}

// n boxes, each shifted a little from the one before. Faces lie in common planes, and each point lies in many
// boxes.
GrowthInput overlaps(std::uint32_t n, std::uint64_t) {
  std::vector<Mesh> all;
  for (std::uint32_t k = 0; k < n; ++k) {
    const double x = static_cast<double>(k) / std::max(n, 1u);
    all.push_back(box({x, 0, 0}, {x + 1, 1, 1}));
  }
  return {joined(all), {}, 20};
}

// n copies of one sphere, each with its own node.
GrowthInput instances(std::uint32_t n, std::uint64_t) {
  const Mesh one = sphere_with(500, 0.4);
  const auto side = static_cast<std::uint32_t>(root_of(n));
  std::vector<Mesh> all;
  for (std::uint32_t k = 0; k < n; ++k)
    all.push_back(translated(one, {static_cast<double>(k % side), static_cast<double>(k / side), 0}));
  Mesh mesh = joined(all);
  mesh.node_names.clear();
  for (std::uint32_t k = 0; k < n; ++k) mesh.node_names.push_back("copy " + std::to_string(k));
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    mesh.node[t] = static_cast<std::uint32_t>(t / one.triangles.size());
  return {mesh, {}, n};
}

Mesh small_sphere() { return sphere_with(2000); }
GrowthInput far_away(std::uint32_t n, std::uint64_t) {
  return {translated(scaled(small_sphere(), {0.01, 0.01, 0.01}), {10, -20, 30}), {}, n};
}
GrowthInput huge(std::uint32_t n, std::uint64_t) { return {scaled(small_sphere(), {1e9, 1e9, 1e9}), {}, n}; }
GrowthInput tiny(std::uint32_t n, std::uint64_t) {
  return {scaled(small_sphere(), {1e-9, 1e-9, 1e-9}), {}, n};
}

}  // namespace

Mesh prism_over(const std::vector<Vec2d>& polygon) {
  Mesh mesh;
  const auto n = static_cast<std::uint32_t>(polygon.size());
  for (const double z : {0.0, 1.0})
    for (const Vec2d& p : polygon) add(mesh, {p.x, p.y, z});
  for (std::uint32_t k = 0; k < n; ++k) add_quad(mesh, k, (k + 1) % n, n + (k + 1) % n, n + k);
  for (std::uint32_t k = 1; k + 1 < n; ++k)
    mesh.triangles.insert(mesh.triangles.end(), {{0, k + 1, k}, {n, n + k, n + k + 1}});
  finish(mesh, "growth");
  return mesh;
}

Mesh parallelepiped(const Vec3d& corner, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  Mesh mesh = box({0, 0, 0}, {1, 1, 1});
  for (Vec3f& p : mesh.positions)
    p = to_float(corner + static_cast<double>(p.x) * a + static_cast<double>(p.y) * b +
                 static_cast<double>(p.z) * c);
  return mesh;
}

const std::vector<GrowthFamily>& growth_families() {
  static const std::vector<GrowthFamily> all{
      {"pane", "sites in a pane of 12 triangles", {1000, 3000, 10'000, 30'000}, pane},
      {"comb", "regions that one plane cuts", {2500, 10'000, 40'000, 160'000}, comb},
      {"bricks", "separate bricks", {2500, 10'000, 40'000, 90'000}, bricks},
      {"bars", "long bars whose boxes overlap", {250, 500, 1000, 2000}, bars},
      {"hub", "neighbours of one site", {2500, 5000, 10'000, 20'000}, hub},
      {"lissajous", "points of a loop that crosses itself", {1000, 2000, 4000, 8000}, lissajous},
      {"scribble", "points of a loop that crosses itself everywhere", {1000, 2000, 4000, 8000}, scribble},
      {"thin_boxes", "thin boxes along (0, 1, 1)", {500, 1000, 2000, 4000}, thin_boxes},
      {"matryoshka", "nested shells", {250, 500, 1000, 2000}, matryoshka},
      {"fan", "tetrahedra at one edge", {1000, 4000, 16'000, 64'000}, fan},
      {"holes", "holes", {1000, 4000, 16'000, 64'000}, holes},
      {"cavities", "cavities", {1000, 4000, 16'000, 64'000}, cavities},
      {"umbrella", "triangles at one vertex", {4000, 16'000, 64'000, 256'000}, umbrella},
      {"needles", "triangles that are all cut fifty times", {500, 1000, 2000, 4000}, needles},
      {"overlaps", "boxes that overlap in common planes", {125, 250, 500, 1000}, overlaps},
      {"instances", "copies of a sphere, and sites", {100, 200, 400, 800}, instances},
      {"far", "sites, 3700 sizes from the origin", {500, 1000, 2000, 4000}, far_away},
      {"huge", "sites, in a million kilometres", {500, 1000, 2000, 4000}, huge},
      {"tiny", "sites, in a nanometre", {500, 1000, 2000, 4000}, tiny},
  };
  return all;
}

const GrowthFamily* find_growth_family(const std::string& name) {
  const auto& all = growth_families();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const GrowthFamily& f) { return name == f.name; });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace fracture::test
