// The other peer: Voro++, which computes each Voronoi cell separately. It builds no Delaunay structure. Its
// time covers all cells with neighbour information (compute_all_cells), with about 6 points per block as its
// manual advises.
#include <cmath>
#include <voro++/voro++.hh>

#include "tests/bench/delaunay_workloads.hpp"

int main(int argc, char** argv) {
  using namespace fracture;
  const bench::Arguments arguments = bench::parse_arguments(argc, argv);
  for (const std::string& name : arguments.workloads) {
    const bench::Workload w = bench::make_workload(name);
    Box box;
    for (const Vec3d& p : w.points) box.add(p);
    const double margin = 0.01 * box.longest_side();
    const int blocks = std::max(1, static_cast<int>(std::cbrt(static_cast<double>(w.points.size()) / 6)));
    std::uint64_t facets = 0;
    const double ms = bench::best_milliseconds(arguments.runs, [&] {
      voro::container container(box.min.x - margin, box.max.x + margin, box.min.y - margin,
                                box.max.y + margin, box.min.z - margin, box.max.z + margin, blocks, blocks,
                                blocks, false, false, false, 8);
      for (std::size_t i = 0; i < w.points.size(); ++i)
        container.put(static_cast<int>(i), w.points[i].x, w.points[i].y, w.points[i].z);
      voro::c_loop_all loop(container);
      voro::voronoicell_neighbor cell;
      facets = 0;
      if (loop.start()) do
          if (container.compute_cell(cell, loop)) facets += cell.number_of_faces();
        while (loop.inc());
    });
    bench::print_result(w, ms, facets, 0);  // facets of all cells instead of tetrahedra
  }
}
