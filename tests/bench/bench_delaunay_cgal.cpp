// The peer: CGAL Delaunay_triangulation_3 with exact predicates and static filters, range insertion (which
// sorts spatially), and one thread. Only the sites are timed. The answers are compared on the sites plus the
// corners of our big tetrahedron, because both programs must find the same set of tetrahedra there on generic
// inputs. --check prints the hash.
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <utility>

#include "common/delaunay/big_tetrahedron.hpp"
#include "tests/bench/delaunay_workloads.hpp"

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Plain = CGAL::Delaunay_triangulation_3<Kernel>;
using Numbered = CGAL::Delaunay_triangulation_3<
    Kernel,
    CGAL::Triangulation_data_structure_3<CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, Kernel>,
                                         CGAL::Delaunay_triangulation_cell_base_3<Kernel>>>;

int main(int argc, char** argv) {
  using namespace fracture;
  const bench::Arguments arguments = bench::parse_arguments(argc, argv);
  for (const std::string& name : arguments.workloads) {
    const bench::Workload w = bench::make_workload(name);
    std::vector<Kernel::Point_3> points;
    for (const Vec3d& p : w.points) points.emplace_back(p.x, p.y, p.z);
    std::size_t cells = 0;
    const double ms = bench::best_milliseconds(arguments.runs, [&] {
      const Plain t(points.begin(), points.end());
      cells = t.number_of_finite_cells();
    });
    bench::TetSetHash hash;
    if (arguments.check) {
      Box box;
      for (const Vec3d& p : w.points) box.add(p);
      std::vector<std::pair<Kernel::Point_3, std::uint32_t>> numbered;
      for (const Kernel::Point_3& p : points)
        numbered.emplace_back(p, static_cast<std::uint32_t>(numbered.size()));
      for (const Vec3d& c : big_tetrahedron(box).corners())
        numbered.emplace_back(Kernel::Point_3(c.x, c.y, c.z), static_cast<std::uint32_t>(numbered.size()));
      const Numbered t(numbered.begin(), numbered.end());
      for (auto cell = t.finite_cells_begin(); cell != t.finite_cells_end(); ++cell)
        hash.add({cell->vertex(0)->info(), cell->vertex(1)->info(), cell->vertex(2)->info(),
                  cell->vertex(3)->info()});
      cells = hash.count();
    }
    bench::print_result(w, ms, cells, hash.value());
  }
}
