#include <algorithm>
#include <cmath>
#include <optional>

#include "common/solid/solid.hpp"

namespace fracture {
namespace {

[[noreturn]] void broken(const std::string& what) { throw InternalError("Solid: " + what); }
std::string name(const char* kind, std::size_t id) { return std::string(kind) + " " + std::to_string(id); }

void check_sizes(const Solid& s) {
  const std::size_t n = s.triangles.size();
  if (!s.source) broken("no source");
  if (n == 0) broken("no triangles");
  if (s.wedges.size() != n || s.material.size() != n || s.edges.size() != n || s.shell.size() != n ||
      s.part.size() != n)
    broken("per-triangle arrays differ in length");
  if (2 * s.edge_vertices.size() != 3 * n) broken("the number of edges is not 3/2 of the triangles");
}

void check_corners(const Solid& s) {
  const auto same = [](const Vec3f& a, const Vec3f& b) { return a == b; };
  std::vector<std::uint8_t> used(s.positions.size(), 0);
  Box box;
  for (std::size_t t = 0; t < s.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t v = s.triangles[t][k];
      if (v >= s.positions.size()) broken(name("triangle", t) + " uses a vertex that does not exist");
      used[v] = 1;
      box.add(to_double(s.positions[v]));
      if (same(s.positions[v], s.positions[s.triangles[t][(k + 1) % 3]]))
        broken(name("triangle", t) + " has two corners at one position");
    }
    const auto& w = s.wedges[t];
    const bool filled = w[0] == kNoIndex;
    if (filled != (s.material[t] == kInteriorMaterial))
      broken(name("triangle", t) + ": fill and material disagree");
    for (const std::uint32_t wedge : w)
      if (filled ? wedge != kNoIndex : wedge >= s.source->positions.size())
        broken(name("triangle", t) + " has a wedge that does not exist");
  }
  if (std::find(used.begin(), used.end(), 0) != used.end()) broken("an unused vertex");
  if (!(box.min == s.box.min && box.max == s.box.max)) broken("the box is not the box of the vertices");
}

void check_edges(const Solid& s) {
  struct Uses {
    std::uint32_t forward = 0, backward = 0;
  };
  std::vector<Uses> uses(s.edge_vertices.size());
  for (std::size_t e = 0; e < s.edge_vertices.size(); ++e)
    if (s.edge_vertices[e][0] >= s.edge_vertices[e][1])
      broken(name("edge", e) + " does not have its lower vertex first");
  for (std::size_t t = 0; t < s.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t e = s.edges[t][k], u = s.triangles[t][k], v = s.triangles[t][(k + 1) % 3];
      if (e >= uses.size()) broken(name("triangle", t) + " uses an edge that does not exist");
      if (s.edge_vertices[e][0] != std::min(u, v) || s.edge_vertices[e][1] != std::max(u, v))
        broken(name("edge", e) + " does not join the corners of " + name("triangle", t));
      ++(u < v ? uses[e].forward : uses[e].backward);
    }
  for (std::size_t e = 0; e < uses.size(); ++e)
    if (uses[e].forward != 1 || uses[e].backward != 1)
      broken(name("edge", e) + " is not used once in each direction");
}

/// Checks that each vertex has one fan: walking around it across edges visits all its corners.
void check_umbrellas(const Solid& s) {
  std::vector<std::uint32_t> other(3 * s.triangles.size(), kNoIndex),
      first_use(s.edge_vertices.size(), kNoIndex);
  std::vector<std::uint32_t> corners(s.positions.size(), 0), start(s.positions.size(), kNoIndex);
  for (std::uint32_t h = 0; h < other.size(); ++h) {
    const std::uint32_t e = s.edges[h / 3][h % 3], v = s.triangles[h / 3][h % 3];
    if (first_use[e] == kNoIndex) {
      first_use[e] = h;
    } else {
      other[h] = first_use[e];
      other[first_use[e]] = h;
    }
    ++corners[v];
    start[v] = h;
  }
  for (std::size_t v = 0; v < corners.size(); ++v) {
    std::uint32_t met = 0, h = start[v];
    do {
      ++met;
      h = other[h % 3 == 0 ? h + 2 : h - 1];
    } while (h != start[v] && met <= corners[v]);
    if (met != corners[v]) broken(name("vertex", v) + " has more than one fan of triangles");
  }
  for (std::uint32_t h = 0; h < other.size(); ++h)
    if (s.shell[h / 3] != s.shell[other[h] / 3])
      broken(name("edge", s.edges[h / 3][h % 3]) + " joins two shells");
}

/// Finds two of these parts whose boxes touch. Divides the boxes at planes that few boxes straddle, until few
/// enough are left to compare all pairs.
std::optional<std::array<std::uint32_t, 2>> find_touching(const std::vector<Part>& parts,
                                                          const std::vector<std::uint32_t>& among) {
  std::vector<std::uint32_t> below, above, fewest_below, fewest_above;
  std::size_t fewest = among.size() + among.size() / 2;
  for (int axis = 0; axis < 3 && among.size() > 16; ++axis) {
    std::vector<double> centers;
    for (const std::uint32_t p : among) centers.push_back(parts[p].box.center()[axis]);
    std::nth_element(centers.begin(), centers.begin() + static_cast<std::ptrdiff_t>(centers.size() / 2),
                     centers.end());
    const double plane = centers[centers.size() / 2];
    below.clear();
    above.clear();
    for (const std::uint32_t p : among) {
      if (parts[p].box.min[axis] <= plane) below.push_back(p);
      if (parts[p].box.max[axis] >= plane) above.push_back(p);
    }
    if (below.size() + above.size() >= fewest) continue;
    if (below.size() == among.size() || above.size() == among.size()) continue;
    fewest = below.size() + above.size();
    fewest_below = below;
    fewest_above = above;
  }
  if (!fewest_below.empty()) {
    if (const auto found = find_touching(parts, fewest_below)) return found;
    return find_touching(parts, fewest_above);
  }
  for (std::size_t i = 0; i < among.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const Part &p = parts[among[i]], &q = parts[among[k]];
      if (p.box.intersects(q.box)) return std::array{among[i], among[k]};
    }
  return std::nullopt;
}

void check_layers(const Solid& s) {
  std::vector<std::vector<std::uint32_t>> of_layer(s.layers);
  for (std::uint32_t p = 0; p < s.parts.size(); ++p) {
    if (s.parts[p].layer >= s.layers) broken(name("part", p) + " has a layer that does not exist");
    of_layer[s.parts[p].layer].push_back(p);
  }
  for (const std::vector<std::uint32_t>& parts : of_layer)
    if (const auto found = find_touching(s.parts, parts))
      broken(name("part", (*found)[0]) + " and " + name("part", (*found)[1]) + " touch in one layer");
}

void check_parts(const Solid& s) {
  if (s.parts.empty()) broken("no parts");
  std::vector<std::uint32_t> part_of_shell;
  for (std::uint32_t p = 0; p < s.parts.size(); ++p) {
    const Part& part = s.parts[p];
    if (part.shells.empty()) broken(name("part", p) + " has no shell");
    if (!(part.volume > 0)) broken(name("part", p) + " has no positive volume");
    for (const std::uint32_t shell : part.shells) {
      if (part_of_shell.size() <= shell) part_of_shell.resize(shell + 1, kNoIndex);
      if (part_of_shell[shell] != kNoIndex) broken(name("shell", shell) + " is in two parts");
      part_of_shell[shell] = p;
    }
  }
  std::vector<double> volume(part_of_shell.size(), 0);
  std::vector<Box> box(s.parts.size());
  for (std::size_t t = 0; t < s.triangles.size(); ++t) {
    if (t > 0 && s.part[t] < s.part[t - 1]) broken(name("triangle", t) + " is not grouped by part");
    if (s.shell[t] >= part_of_shell.size() || part_of_shell[s.shell[t]] != s.part[t])
      broken(name("triangle", t) + ": shell and part disagree");
    const Vec3d origin = s.box.center();
    const Vec3d a = to_double(s.positions[s.triangles[t][0]]) - origin,
                b = to_double(s.positions[s.triangles[t][1]]) - origin,
                c = to_double(s.positions[s.triangles[t][2]]) - origin;
    volume[s.shell[t]] += dot(a, cross(b, c));
    for (const std::uint32_t v : s.triangles[t]) box[s.part[t]].add(to_double(s.positions[v]));
  }
  double total = 0;
  const Vec3d size = s.box.size();
  const double noise = 1e-9 * size.x * size.y * size.z;
  for (std::uint32_t p = 0; p < s.parts.size(); ++p) {
    const Part& part = s.parts[p];
    double sum = 0;
    for (std::size_t k = 0; k < part.shells.size(); ++k) {
      const double v = volume[part.shells[k]] / 6;
      if (k == 0 ? v < -noise : v > noise) broken(name("shell", part.shells[k]) + " faces the wrong way");
      sum += v;
    }
    if (std::fabs(sum - part.volume) > noise + 1e-9 * part.volume)
      broken(name("part", p) + " states a wrong volume");
    if (!(box[p].min == part.box.min && box[p].max == part.box.max))
      broken(name("part", p) + " states a wrong box");
    total += part.volume;
  }
  if (total != s.report.volume) broken("the report's volume differs from the sum of the parts' volumes");
}

}  // namespace

void Solid::validate() const {
  check_sizes(*this);
  check_corners(*this);
  check_edges(*this);
  check_umbrellas(*this);
  check_parts(*this);
  check_layers(*this);
}

}  // namespace fracture
