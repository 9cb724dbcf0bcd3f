// The whole fracture from a mesh in memory, stage by stage: make_solid, make_diagram (sites +
// tetrahedralization), fracture.
//
//   bench_fracture [--out FOLDER] [--threads T] [--filter TEXT] [--seconds S]
//
// One line per workload: median milliseconds (whole and by stage), fragments, relative volume error, and the
// hash of all fragments; each repetition must give the same hash, a closed certificate and the volume to
// 1e-9, or the program fails. With
// --out each workload is also written for the peer (tests/bench/manifold/fracture.mjs): the solid's
// triangles, and for each site the vertices of its Voronoi cell within an enlarged box, so that the peer gets
// its cells for free.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include "common/digest/digest.hpp"
#include "common/pipeline/fracture.hpp"
#include "tests/bench/stopwatch.hpp"
#include "tests/support/mesh_files.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::bench {
namespace {

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

std::string hash_of(const FragmentSet& set) {
  std::string bytes;
  const auto append = [&bytes](const auto& items) {
    if (!items.empty())
      bytes.append(reinterpret_cast<const char*>(items.data()), items.size() * sizeof(items[0]));
  };
  for (const Fragment& f : set.fragments) {
    append(f.positions);
    append(f.indices);
    append(f.attributes.normals);
    bytes.append(reinterpret_cast<const char*>(&f.pivot), sizeof f.pivot);
  }
  return sha256(bytes).hex().substr(0, 16);
}

// -- cells for the peer

using Polygon = std::vector<Vec3d>;

/// Keeps the part of the convex polyhedron where dot(normal, x) <= offset; closes it with one face.
void clip_polyhedron(std::vector<Polygon>& faces, const Vec3d& normal, double offset) {
  std::vector<Polygon> kept;
  Polygon lid;
  for (const Polygon& face : faces) {
    Polygon clipped;
    for (std::size_t i = 0; i < face.size(); ++i) {
      const Vec3d &a = face[i], &b = face[(i + 1) % face.size()];
      const double da = dot(normal, a) - offset, db = dot(normal, b) - offset;
      if (da <= 0) clipped.push_back(a);
      if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
        const Vec3d p = a + (da / (da - db)) * (b - a);
        clipped.push_back(p);
        lid.push_back(p);
      }
    }
    if (clipped.size() >= 3) kept.push_back(std::move(clipped));
  }
  if (lid.size() >= 3) {
    Vec3d center;
    for (const Vec3d& p : lid) center = center + (1.0 / static_cast<double>(lid.size())) * p;
    const Vec3d u = lid[0] - center, v = cross(normal, u);
    std::sort(lid.begin(), lid.end(), [&](const Vec3d& a, const Vec3d& b) {
      return std::atan2(dot(a - center, v), dot(a - center, u)) <
             std::atan2(dot(b - center, v), dot(b - center, u));
    });
    kept.push_back(std::move(lid));
  }
  faces = std::move(kept);
}

std::vector<Vec3d> cell_vertices(const Tetrahedralization& t, SiteId site,
                                 const std::vector<SiteId>& neighbours, const Box& box) {
  const Vec3d grown = 0.1 * box.size(), low = box.min - grown, high = box.max + grown;
  const auto corner = [&](int i) {
    return Vec3d{i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z};
  };
  std::vector<Polygon> faces;
  for (const auto& quad : {std::array{0, 2, 3, 1}, std::array{4, 5, 7, 6}, std::array{0, 1, 5, 4},
                           std::array{2, 6, 7, 3}, std::array{0, 4, 6, 2}, std::array{1, 3, 7, 5}})
    faces.push_back({corner(quad[0]), corner(quad[1]), corner(quad[2]), corner(quad[3])});
  const Vec3d p = t.points[site];
  for (const SiteId n : neighbours) {
    const Vec3d q = t.points[n], normal = q - p;
    clip_polyhedron(faces, normal, dot(normal, 0.5 * (p + q)));
  }
  std::vector<Vec3d> vertices;
  for (const Polygon& face : faces) vertices.insert(vertices.end(), face.begin(), face.end());
  std::sort(vertices.begin(), vertices.end(), lexicographic_less);
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

/// Little-endian: u32 vertices, triangles, sites, points; f64 points[3]…; f32 positions[3]…; u32
/// triangles[3]…; u32 first point of each site (and the end).
void write_for_peer(const std::string& path, const Solid& solid, const Tetrahedralization& t) {
  std::vector<std::vector<SiteId>> neighbours(t.site_count());
  for (const Tetrahedron& tet : t.tets)
    for (const SiteId a : tet.v)
      for (const SiteId b : tet.v)
        if (a != b && !t.is_corner(a) && !t.is_corner(b)) neighbours[a].push_back(b);
  std::vector<Vec3d> points;
  std::vector<std::uint32_t> first{0};
  for (const SiteId s : ids<SiteId>(t.site_count())) {
    std::sort(neighbours[s].begin(), neighbours[s].end());
    neighbours[s].erase(std::unique(neighbours[s].begin(), neighbours[s].end()), neighbours[s].end());
    const std::vector<Vec3d> cell = cell_vertices(t, s, neighbours[s], solid.box);
    points.insert(points.end(), cell.begin(), cell.end());
    first.push_back(static_cast<std::uint32_t>(points.size()));
  }
  std::ofstream out(path, std::ios::binary);
  const auto write = [&out](const auto& items) {
    out.write(reinterpret_cast<const char*>(items.data()),
              static_cast<std::streamsize>(items.size() * sizeof(items[0])));
  };
  const std::vector<std::uint32_t> counts{static_cast<std::uint32_t>(solid.positions.size()),
                                          static_cast<std::uint32_t>(solid.triangles.size()), t.site_count(),
                                          static_cast<std::uint32_t>(points.size())};
  write(counts);
  write(points);
  write(solid.positions);
  write(solid.triangles);
  write(first);
}

// -- workloads

struct Options {
  std::string out, filter;
  int threads = 1;
  double seconds = 1;
};

/// Returns false when an answer is wrong.
bool run(const std::string& name, const std::shared_ptr<const Mesh>& mesh, std::uint32_t sites,
         const Options& options, nlohmann::json& results) {
  Execution execution;
  execution.threads = options.threads;
  FractureParameters parameters;
  parameters.sites = sites;
  std::vector<double> whole, solid_ms, diagram_ms, fracture_ms;
  std::string hash;
  FragmentSet set;
  Solid solid;
  Diagram diagram;
  const double begin = now_ms();
  do {
    StageTimings timings;
    const double t0 = now_ms();
    Expected<Solid> s = make_solid(mesh, {}, execution);
    const double t1 = now_ms();
    Expected<Diagram> d =
        s ? make_diagram(*s, parameters, execution, timings) : Expected<Diagram>(tl::unexpected(s.error()));
    const double t2 = now_ms();
    Expected<FracturedSolid> f = d ? fracture(*s, *d, parameters, execution, timings)
                                   : Expected<FracturedSolid>(tl::unexpected(d.error()));
    const double t3 = now_ms();
    if (!f) {
      std::printf("%-12s %5u sites: %s: %s\n", name.c_str(), sites, slug(f.error().code),
                  f.error().detail.c_str());
      return false;
    }
    whole.push_back(t3 - t0);
    solid_ms.push_back(t1 - t0);
    diagram_ms.push_back(t2 - t1);
    fracture_ms.push_back(t3 - t2);
    const std::string h = hash_of(f->set);
    if (!hash.empty() && h != hash) {
      std::printf("%s, %u sites: two runs gave different fragments\n", name.c_str(), sites);
      return false;
    }
    hash = h;
    solid = std::move(*s);
    diagram = std::move(*d);
    set = std::move(f->set);
  } while (whole.size() < 3 || (now_ms() - begin < 1000 * options.seconds && whole.size() < 101));
  const Certificate& c = set.certificate;
  const bool right = c.open_edges == 0 && c.relative_error <= 1e-9 && !set.fragments.empty();
  std::printf(
      "%-12s %6zu triangles %5u sites: %9.3f ms (solid %.3f, sites+delaunay %.3f, fracture %.3f) %5zu "
      "fragments, volume error %.1e, %s%s\n",
      name.c_str(), mesh->triangles.size(), sites, median(whole), median(solid_ms), median(diagram_ms),
      median(fracture_ms), set.fragments.size(), c.relative_error, hash.c_str(), right ? "" : " WRONG");
  std::fflush(stdout);
  if (!options.out.empty()) {
    const std::string file = name + "_" + std::to_string(sites) + ".bin";
    write_for_peer((std::filesystem::path(options.out) / file).string(), solid, diagram.tetrahedralization);
    results.push_back({{"name", name},
                       {"file", file},
                       {"triangles", mesh->triangles.size()},
                       {"sites", sites},
                       {"fragments", set.fragments.size()},
                       {"volume", solid.report.volume},
                       {"milliseconds", median(whole)},
                       {"hash", hash}});
  }
  return right;
}

int main_of(int argc, char** argv) {
  Options options;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--out") == 0) options.out = argv[i + 1];
    if (std::strcmp(argv[i], "--filter") == 0) options.filter = argv[i + 1];
    if (std::strcmp(argv[i], "--threads") == 0)
      options.threads = std::max(1, static_cast<int>(std::strtol(argv[i + 1], nullptr, 10)));
    if (std::strcmp(argv[i], "--seconds") == 0) options.seconds = std::strtod(argv[i + 1], nullptr);
  }
  if (!options.out.empty()) std::filesystem::create_directories(options.out);
  std::vector<test::NamedMesh> meshes{{"sphere2k", test::sphere_with(2000)},
                                      {"sphere20k", test::sphere_with(20000)},
                                      {"torus", test::torus(96, 48)}};
  for (const char* name : {"hammer.obj", "penguin.obj"}) {
    const auto file = test::find_test_mesh(name);
    Expected<Mesh> mesh = file ? test::read_obj_positions(file->path) : fail(ErrorCode::kEmptyBody, "absent");
    if (mesh)
      meshes.push_back({std::string(name).substr(0, std::strlen(name) - 4), std::move(*mesh)});
    else
      std::printf("%s is absent: not measured\n", name);
  }
  nlohmann::json results = nlohmann::json::array();
  bool right = true;
  for (test::NamedMesh& shape : meshes) {
    const auto mesh = std::make_shared<const Mesh>(std::move(shape.mesh));
    for (const std::uint32_t sites : {10u, 50u, 300u, 1000u}) {
      const std::string label = shape.name + "_" + std::to_string(sites);
      if (!options.filter.empty() && label.find(options.filter) == std::string::npos) continue;
      right &= run(shape.name, mesh, sites, options, results);
    }
  }
  if (!options.out.empty())
    std::ofstream(std::filesystem::path(options.out) / "workloads.json") << results.dump(1) << '\n';
  return right ? 0 : 1;
}

}  // namespace
}  // namespace fracture::bench

int main(int argc, char** argv) { return fracture::bench::main_of(argc, argv); }
