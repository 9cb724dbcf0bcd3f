// The number of allocations in the steady state, when the threads have their scratch memory. Memory for
// sites, tetrahedra, text and buffers is reused, whatever their number. Only the fragments themselves are
// allocated, with a few arrays for each.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>

#include "common/gltf/gltf_writer.hpp"
#include "common/pipeline/fracture.hpp"
#include "tests/support/shapes.hpp"

namespace {

std::atomic<std::uint64_t> allocations{0};

void* allocate(std::size_t size) {
  ++allocations;
  if (void* const memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}

}  // namespace

void* operator new(std::size_t size) { return allocate(size); }
void* operator new[](std::size_t size) { return allocate(size); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }

namespace fracture {
namespace {

struct Counts {
  std::uint64_t diagram, fragments, file;
};

/// Counts the third of three fractures of the mesh on one thread, each with a different seed.
Counts count(const Solid& solid, std::uint32_t sites, Hulls hulls) {
  const Execution execution;
  StageTimings timings;
  FractureParameters parameters;
  parameters.sites = sites;
  parameters.hulls = hulls;
  Counts counts{};
  for (parameters.seed = 1; parameters.seed <= 3; ++parameters.seed) {
    const std::uint64_t start = allocations;
    const Diagram diagram = make_diagram(solid, parameters, execution, timings).value();
    const std::uint64_t sited = allocations;
    const FracturedSolid made = fracture(solid, diagram, parameters, execution, timings).value();
    const std::uint64_t cut = allocations;
    EXPECT_FALSE(write_glb(made, {}).empty());
    counts = {sited - start, cut - sited, allocations - cut};
  }
  return counts;
}

class Allocations : public testing::TestWithParam<std::uint32_t> {
 protected:
  const Solid solid =
      make_solid(std::make_shared<const Mesh>(test::sphere_with(1000)), {}, Execution{}).value();
};

TEST_P(Allocations, OnlyFragmentsAreAllocatedOneByOne) {
  const std::uint32_t sites = GetParam();
  const Counts flat = count(solid, sites, Hulls::kNone);
  EXPECT_LE(flat.diagram, 120u);
  EXPECT_LE(flat.fragments, 400 + 16 * sites);
  EXPECT_LE(flat.file, 150u);
}

TEST_P(Allocations, AHullIsFourArraysAndItsName) {
  const std::uint32_t sites = GetParam();
  const Counts flat = count(solid, sites, Hulls::kNone), hulls = count(solid, sites, Hulls::kConvex);
  EXPECT_LE(hulls.fragments, flat.fragments + 50 + 4 * sites);
  EXPECT_LE(hulls.file, flat.file + 50 + sites);
}

INSTANTIATE_TEST_SUITE_P(Sites, Allocations, testing::Values(10u, 50u, 200u, 1000u, 5000u));

}  // namespace
}  // namespace fracture
