// Fuzz target: any mesh and any parameters (fracture_case.hpp) through make_solid, make_diagram and fracture,
// including hits and fragments that are fractured again. The answer is sound by the invariants of
// tests/property, or an error. There is no exception, and never more than 50 ms of processor time between two
// polls, so that an interruption takes effect within that time. Otherwise the target prints how to repeat the
// input, and aborts.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <set>
#include <string>

#include "common/hits/delta.hpp"
#include "tests/fuzz/fracture_case.hpp"
#include "tests/property/violations.hpp"
#include "tests/support/poll_gaps.hpp"
#include "tests/support/surface_mesh.hpp"

namespace fracture::fuzz {
namespace {

using test::Violations;

/// How many times as long as a release build without sanitizers this build may take.
#if defined(FRACTURE_SANITIZED)
constexpr double kSlowness = 12;
#elif !defined(NDEBUG)
constexpr double kSlowness = 8;
#else
constexpr double kSlowness = 1;
#endif
constexpr double kBetweenPolls = 0.05 * kSlowness;  ///< seconds of the thread's processor time
constexpr std::chrono::seconds kDeadline(kSlowness > 1 ? 12 : 4);

/// Measures the time between polls of one thread, until it is destroyed or restarted with skip().
class Watched {
 public:
  Watched() {
    execution.deadline = std::chrono::steady_clock::now() + kDeadline;
    execution.watch = [this] { step(); };
    execution.progress = [this](Stage stage, double) { stage_ = name_of(stage); };
    last_ = now();
  }
  void step() {
    const double now = this->now();
    if (now - last_ > longest_) {
      longest_ = now - last_;
      where_ = stage_;
    }
    last_ = now;
  }
  /// Excludes the time since the last poll, in which the target worked, not the library.
  void skip() { last_ = now(); }
  double longest() const { return longest_; }
  const std::string& where() const { return where_; }

  Execution execution;

 private:
  double now() const { return 1e-3 * clock_.ms(); }

  test::WorkClock clock_;
  double last_ = 0, longest_ = 0;  // seconds
  std::string stage_ = "the beginning", where_ = "the beginning";
};

struct Outcome {
  std::string word;  ///< "sound", or slug and pointer of the error
  Violations violations;
};

void append(Violations& all, const std::string& what, const Violations& some) {
  for (const std::string& one : some) all.push_back(what + ": " + one);
}

/// Returns the solid's own triangles as a mesh. Each triangle gets its number as material, also in the solid.
/// The mesh is empty if filled triangles lack attributes: a mesh with attributes must have them on all
/// triangles except those of the interior material.
Mesh traced_surface(Solid& solid, test::Whole& whole) {
  const Attributes& attributes = solid.source->attributes;
  const bool with_attributes = !attributes.normals.empty() || !attributes.tangents.empty() ||
                               !attributes.uvs.empty() || !attributes.colors.empty();
  whole.filled = with_attributes && std::find(solid.material.begin(), solid.material.end(),
                                              kInteriorMaterial) != solid.material.end();
  if (whole.filled) return {};
  Mesh mesh = test::surface_mesh(solid);
  for (std::uint32_t t = 0; t < solid.material.size(); ++t) solid.material[t] = t;
  mesh.material = solid.material;
  return mesh;
}

/// Volume, area and the sum of the shells' absolute volumes, from the triangles alone.
test::Whole measures(const Solid& solid) {
  std::vector<long double> six;
  std::vector<Vec3d> origin;  // one for each shell, because distant shells would cancel
  test::Whole whole;
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    const auto corner = [&](std::size_t k) { return to_double(solid.positions[solid.triangles[t][k]]); };
    if (solid.shell[t] >= six.size()) {
      six.resize(solid.shell[t] + 1);
      origin.resize(solid.shell[t] + 1, corner(0));
    }
    const Vec3d& o = origin[solid.shell[t]];
    const Vec3d a = corner(0) - o, b = corner(1) - o, c = corner(2) - o;
    six[solid.shell[t]] += static_cast<long double>(a.x) *
                               (static_cast<long double>(b.y) * c.z - static_cast<long double>(b.z) * c.y) +
                           static_cast<long double>(a.y) *
                               (static_cast<long double>(b.z) * c.x - static_cast<long double>(b.x) * c.z) +
                           static_cast<long double>(a.z) *
                               (static_cast<long double>(b.x) * c.y - static_cast<long double>(b.y) * c.x);
    whole.area += 0.5 * length(cross(b - a, c - a));
  }
  for (const long double v : six) {
    whole.volume += static_cast<double>(v / 6);
    whole.magnitude += std::fabs(static_cast<double>(v / 6));
  }
  return whole;
}

/// Compares the bits that would be written to the answer.
bool same_fragments(const FragmentSet& a, const FragmentSet& b) {
  if (a.fragments.size() != b.fragments.size()) return false;
  for (std::size_t k = 0; k < a.fragments.size(); ++k) {
    const Fragment &f = a.fragments[k], &g = b.fragments[k];
    if (f.id != g.id || f.pivot != g.pivot || f.positions != g.positions || f.indices != g.indices)
      return false;
  }
  return true;
}

Violations judge(const FragmentSet& set, const FractureParameters& parameters, const test::Whole& whole,
                 const Mesh& surface, bool only_changed = false) {
  Violations all;
  append(all, "closed", test::closed_violations(set));
  const Certificate& c = set.certificate;
  if (c.open_edges != 0)
    all.push_back("the certificate counts " + std::to_string(c.open_edges) + " open edges");
  if (parameters.dual == Dual::kBarycenter || only_changed) return all;
  append(all, "partition", test::partition_violations(set, whole));
  // Sheets without volume and pockets are left out; then the outside is not covered everywhere.
  if (!whole.filled)
    append(all, "outside", test::outside_violations(set, surface, c.pocket_area == 0 && c.dropped == 0));
  if (c.fragments != c.cells + c.islands - c.united - c.dropped)
    all.push_back("fragments are not cells + islands - united - dropped");
  if (std::set<std::uint64_t> ids; true) {
    for (const Fragment& f : set.fragments) ids.insert(f.id);
    if (ids.size() != set.fragments.size()) all.push_back("two fragments have one id");
  }
  return all;
}

std::string word_of(const Error& error, Violations& violations) {
  const std::string name = slug(error.code);
  // A refusal of an unsound answer is a failure here, because that fallback must never be needed.
  if (error.code == ErrorCode::kInternal || name == "unsound")
    violations.push_back(name + ": " + error.detail);
  return error.pointer.empty() ? name : name + " " + error.pointer;
}

/// A hit on an answer must give the same result as computing everything from scratch.
Outcome run_hits(const Solid& solid, const FractureParameters& parameters, const NewHits& new_hits,
                 const test::Whole& whole, const Mesh& surface, Watched& watched) {
  Outcome outcome{"sound", {}};
  const Execution& execution = watched.execution;
  StageTimings timings;
  const FractureParameters without = before_hits(parameters, new_hits.count);
  const Expected<KeptAnswer> before = fracture_and_keep(solid, without, execution, timings);
  if (!before) return outcome.word = word_of(before.error(), outcome.violations), outcome;
  watched.step();
  append(outcome.violations, "before the hits", judge(before->fractured.set, without, whole, surface));
  watched.skip();
  const Expected<KeptAnswer> after =
      fracture_delta(solid, before->base, parameters, new_hits, execution, timings);
  if (!after) return outcome.word = word_of(after.error(), outcome.violations), outcome;
  watched.step();
  append(outcome.violations, "after the hits",
         judge(after->fractured.set, parameters, whole, surface, new_hits.only_changed));
  watched.skip();
  if (new_hits.only_changed) return outcome;
  const Expected<KeptAnswer> again = fracture_and_keep(solid, parameters, execution, timings);
  if (!again) return outcome.word = word_of(again.error(), outcome.violations), outcome;
  if (!same_fragments(after->fractured.set, again->fractured.set))
    outcome.violations.push_back("hits on a kept answer: not what all sites make from nothing");
  return outcome;
}

Outcome run_once(const FractureCase& c, Watched& watched) {
  Outcome outcome{"sound", {}};
  const Execution& execution = watched.execution;
  FractureParameters parameters = c.parameters.fracture;
  StageTimings timings;
  Mesh mesh = c.mesh;
  if (auto frame = to_metres_y_up(mesh, c.parameters.frame); !frame)
    return outcome.word = word_of(frame.error(), outcome.violations), outcome;
  if (auto selected = restrict_to(mesh, c.parameters.parts); !selected)
    return outcome.word = word_of(selected.error(), outcome.violations), outcome;
  Expected<Solid> solid = make_solid(std::make_shared<Mesh>(std::move(mesh)), c.parameters.solid, execution);
  if (!solid) return outcome.word = word_of(solid.error(), outcome.violations), outcome;
  watched.step();
  solid->validate();
  test::Whole whole = measures(*solid);
  watched.skip();
  if (!c.has_refracture) {
    const Mesh surface = traced_surface(*solid, whole);
    watched.skip();
    if (const std::optional<NewHits>& hits = c.parameters.selection.new_hits)
      return run_hits(*solid, parameters, *hits, whole, surface, watched);
    const Expected<Diagram> diagram = make_diagram(*solid, parameters, execution, timings);
    if (!diagram) return outcome.word = word_of(diagram.error(), outcome.violations), outcome;
    const Expected<FracturedSolid> made =
        fracture::fracture(*solid, *diagram, parameters, execution, timings);
    watched.step();
    if (!made) return outcome.word = word_of(made.error(), outcome.violations), outcome;
    append(outcome.violations, "answer", judge(made->set, parameters, whole, surface));
    return outcome;
  }
  // Fractures one of the fragments again.
  const Expected<Diagram> diagram = make_diagram(*solid, parameters, execution, timings);
  if (!diagram) return outcome.word = word_of(diagram.error(), outcome.violations), outcome;
  const Expected<FracturedSolid> first = fracture::fracture(*solid, *diagram, parameters, execution, timings);
  if (!first) return outcome.word = word_of(first.error(), outcome.violations), outcome;
  if (parameters.dual == Dual::kBarycenter) return outcome;
  const Fragment& chosen = first->set.fragments[c.refracture % first->set.fragments.size()];
  const Refracture wanted{.fragment = chosen.id, .sites = 1 + c.refracture % 20, .seed = c.refracture};
  const Expected<FracturedSolid> parts = refracture(*solid, *diagram, parameters, wanted, execution, timings);
  if (!parts) return outcome.word = word_of(parts.error(), outcome.violations), outcome;
  append(outcome.violations, "of a fragment", test::closed_violations(parts->set));
  const Certificate& certificate = parts->set.certificate;
  if (certificate.open_edges != 0 || !(certificate.relative_error <= 1e-9))
    outcome.violations.push_back("of a fragment: open edges or volume");
  return outcome;
}

Outcome run(const FractureCase& c) {
  // A long time between polls counts only if it recurs, because the machine does other things as well.
  Outcome outcome;
  for (int attempt = 0; attempt < 3; ++attempt) {
    Watched watched;
    try {
      outcome = run_once(c, watched);
    } catch (const std::exception& e) {
      return {"exception", {std::string("exception: ") + e.what()}};
    } catch (...) {
      return {"exception", {"an exception that is none of ours"}};
    }
    if (!outcome.violations.empty() || watched.longest() <= kBetweenPolls) return outcome;
    char text[200];
    std::snprintf(text, sizeof text, "%.0f ms of processor time without a poll in '%s'",
                  1e3 * watched.longest(), watched.where().c_str());
    if (attempt == 2) outcome.violations.push_back(text);
  }
  return outcome;
}

}  // namespace

/// The result of the last input, for programs that count: "sound", or slug and pointer of an error.
std::string& last_outcome() {
  static std::string word;
  return word;
}

}  // namespace fracture::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fracture::fuzz;
  const FractureCase c = decode_case(data, size);
  const Outcome outcome = run(c);
  last_outcome() = outcome.word;
  if (outcome.violations.empty()) return 0;
  std::fprintf(stderr, "not sound: %s (%zu triangles)\nparameters: %s\n", c.shape.c_str(),
               c.mesh.triangles.size(), c.request.dump().c_str());
  if (c.has_refracture) std::fprintf(stderr, "of which fragment %u is fractured again\n", c.refracture);
  for (const std::string& violation : outcome.violations) std::fprintf(stderr, "  %s\n", violation.c_str());
  std::fprintf(stderr, "repeat: fuzz_fracture_run --input ");
  for (std::size_t k = 0; k < size; ++k) std::fprintf(stderr, "%02x", data[k]);
  std::fprintf(stderr, "\n");
  std::fflush(stderr);
  std::abort();
}
