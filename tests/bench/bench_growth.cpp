// Measures how time and memory of the whole fracture grow with its input and output. The inputs are families
// that could make them grow faster (tests/support/growth_families.hpp), and two plain families: sites in a
// sphere, and triangles of a sphere.
//
//   bench_growth [--family NAME[,NAME...]] [--sizes N[,N...]] [--runs N] [--limit SECONDS] [--seed S]
//                [--program-label TEXT]
//
// For each size it prints the processor milliseconds of make_solid, make_diagram and fracture with one thread
// (the least of the runs), the peak memory above that of the mesh, and the size of the output. Each size runs
// in its own process, which may take `limit` seconds of processor time (default 120) and 12 GiB. Exponents
// are slopes of time and memory, in logarithms, against triangles and sites in plus triangles out. Each line
// shows the exponent since the line before, and the end of a family shows one by least squares. Unsound
// answers are marked, and the program then exits with 1.
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "common/pipeline/fracture.hpp"
#include "tests/support/growth_families.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::bench {
namespace {

struct Family {
  const char* name;
  const char* grows;
  std::vector<std::uint32_t> sizes;
  test::GrowthInput (*make)(std::uint32_t size, std::uint64_t seed);
};

std::vector<Family> all_families() {
  std::vector<Family> all{
      {"sites",
       "uniform sites in a sphere of 20k triangles",
       {10, 100, 1000, 10'000, 100'000},
       [](std::uint32_t size, std::uint64_t) {
         return test::GrowthInput{test::sphere_with(20'000), {}, size};
       }},
      {"triangles",
       "triangles of a sphere with 50 sites",
       {1000, 10'000, 100'000, 1'000'000, 4'000'000},
       [](std::uint32_t size, std::uint64_t) {
         return test::GrowthInput{test::sphere_with(static_cast<int>(size)), {}, 50};
       }},
  };
  for (const test::GrowthFamily& family : test::growth_families())
    all.push_back({family.name, family.grows, {family.sizes.begin(), family.sizes.end()}, family.make});
  return all;
}

struct Options {
  std::vector<std::string> families;
  std::vector<std::uint32_t> sizes;
  int runs = 3;
  unsigned limit = 120;
  std::uint64_t seed = 1;
  std::string label;
};

/// The measurements that a child sends to its parent: plain data, written to a pipe.
struct Figures {
  double solid = 0, diagram = 0, fracture = 0;  // ms
  double bytes = 0;
  std::uint64_t triangles_in = 0, sites = 0, triangles_out = 0, fragments = 0, open_edges = 0;
  double relative_error = 0;
  char error[64] = "";
};

/// The processor time of this thread, which does all the work.
double processor_ms() {
  timespec t{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);  // under RLIMIT_CPU the process's clock has steps of 4 ms
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

/// VmHWM or VmRSS of this process, in bytes.
double memory(const char* field) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind(field, 0) == 0) return 1024 * std::strtod(line.c_str() + std::strlen(field) + 1, nullptr);
  return 0;
}

void run_once(const std::shared_ptr<const Mesh>& mesh, const FractureParameters& parameters,
              Figures& figures) {
  const Execution execution;
  StageTimings timings;
  const double t0 = processor_ms();
  const Expected<Solid> solid = make_solid(mesh, {}, execution);
  const double t1 = processor_ms();
  const Expected<Diagram> diagram = solid ? make_diagram(*solid, parameters, execution, timings)
                                          : Expected<Diagram>(tl::unexpected(solid.error()));
  const double t2 = processor_ms();
  const Expected<FracturedSolid> made =
      diagram ? fracture::fracture(*solid, *diagram, parameters, execution, timings)
              : Expected<FracturedSolid>(tl::unexpected(diagram.error()));
  const double t3 = processor_ms();
  if (!made) {
    std::snprintf(figures.error, sizeof figures.error, "%s", slug(made.error().code));
    return;
  }
  const FragmentSet& set = made->set;
  const auto least = [](double& kept, double now) { kept = kept == 0 ? now : std::min(kept, now); };
  least(figures.solid, t1 - t0);
  least(figures.diagram, t2 - t1);
  least(figures.fracture, t3 - t2);
  figures.sites = diagram->sites.size();
  figures.fragments = set.fragments.size();
  figures.triangles_out = 0;
  for (const Fragment& f : set.fragments) figures.triangles_out += f.indices.size() / 3;
  figures.open_edges = set.certificate.open_edges;
  figures.relative_error = set.certificate.relative_error;
}

/// Runs in the child. The peak memory is that of the first run, without the memory of the mesh.
Figures measure(const Family& family, std::uint32_t size, const Options& options) {
  test::GrowthInput input = family.make(size, options.seed);
  FractureParameters parameters;
  parameters.seed = options.seed;
  if (input.sites.empty())
    parameters.sites = input.uniform;
  else
    parameters.pattern = PointsPattern{input.sites};
  const auto mesh = std::make_shared<const Mesh>(std::move(input.mesh));
  Figures figures;
  figures.triangles_in = mesh->triangles.size();
  std::ofstream("/proc/self/clear_refs") << "5";  // resets the peak
  const double before = memory("VmRSS:"), begin = processor_ms();
  run_once(mesh, parameters, figures);
  figures.bytes = std::max(memory("VmHWM:") - before, 0.0);
  // Repeats only short runs.
  for (int k = 1; k < options.runs && figures.error[0] == 0 && processor_ms() - begin < 5000; ++k)
    run_once(mesh, parameters, figures);
  return figures;
}

/// Runs the size in a child. Returns false if the child did not end by itself; `why` says how it ended.
bool measure_in_child(const Family& family, std::uint32_t size, const Options& options, Figures& figures,
                      std::string& why) {
  int ends[2];
  if (::pipe(ends) != 0) return false;
  std::fflush(stdout);
  const pid_t child = ::fork();
  if (child < 0) return false;
  if (child == 0) {
    ::close(ends[0]);
    const rlimit time{options.limit, options.limit + 5}, memory{12ul << 30, 12ul << 30};
    ::setrlimit(RLIMIT_CPU, &time);
    ::setrlimit(RLIMIT_AS, &memory);
    ::alarm(20 * options.limit);  // in case it waits for something
    int code = 1;
    try {
      const Figures f = measure(family, size, options);
      if (::write(ends[1], &f, sizeof f) == static_cast<ssize_t>(sizeof f)) code = 0;
    } catch (const std::bad_alloc&) {
      code = 3;
    } catch (const std::exception& e) {
      std::fprintf(stderr, "%s %u: %s\n", family.name, size, e.what());
    }
    ::_exit(code);
  }
  ::close(ends[1]);
  const bool whole = ::read(ends[0], &figures, sizeof figures) == static_cast<ssize_t>(sizeof figures);
  ::close(ends[0]);
  int status = 0;
  ::waitpid(child, &status, 0);
  if (whole) return true;
  if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGALRM))
    why = "> " + std::to_string(options.limit) + " s";
  else if (WIFEXITED(status) && WEXITSTATUS(status) == 3)
    why = "> 12 GiB";
  else
    why = WIFSIGNALED(status) ? std::string("killed: ") + ::strsignal(WTERMSIG(status)) : "failed";
  return false;
}

/// The slope of y over x, both in logarithms, by least squares; NaN for fewer than two points.
double exponent(const std::vector<double>& x, const std::vector<double>& y) {
  const auto n = static_cast<double>(x.size());
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    const double lx = std::log(x[k]), ly = std::log(y[k]);
    sx += lx;
    sy += ly;
    sxx += lx * lx;
    sxy += lx * ly;
  }
  return x.size() < 2 ? std::nan("") : (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

/// The exponent between the last two points; NaN if there is only one.
double last_exponent(const std::vector<double>& x, const std::vector<double>& y) {
  const auto last_two = [](const std::vector<double>& all) {
    return std::vector<double>(all.end() - std::min<std::ptrdiff_t>(2, std::ssize(all)), all.end());
  };
  return exponent(last_two(x), last_two(y));
}

/// Returns false if an answer is wrong.
bool run(const Family& family, const Options& options) {
  std::printf("%s: %s%s%s\n", family.name, family.grows, options.label.empty() ? "" : ", ",
              options.label.c_str());
  std::printf("  %8s %9s %7s %9s %10s %10s %11s %10s %5s %9s %5s\n", "size", "tri in", "sites", "tri out",
              "solid ms", "diagram ms", "fracture ms", "whole ms", "exp", "peak MiB", "exp");
  std::vector<double> x, time, memory;
  bool right = true;
  for (const std::uint32_t size : options.sizes.empty() ? family.sizes : options.sizes) {
    Figures f;
    std::string why;
    if (!measure_in_child(family, size, options, f, why)) {
      std::printf("  %8u %s\n", size, why.c_str());
      break;  // larger ones would take longer
    }
    if (f.error[0] != 0) {
      std::printf("  %8u %9llu refused: %s\n", size, static_cast<unsigned long long>(f.triangles_in),
                  f.error);
      continue;
    }
    const bool sound = f.open_edges == 0 && f.relative_error <= 1e-9 && f.fragments > 0;
    const double whole = f.solid + f.diagram + f.fracture;
    right &= sound;
    x.push_back(static_cast<double>(f.triangles_in + f.sites + f.triangles_out));
    time.push_back(whole);
    memory.push_back(std::max(f.bytes, 1.0));
    std::printf("  %8u %9llu %7llu %9llu %10.2f %10.2f %11.2f %10.2f %5.2f %9.1f %5.2f%s\n", size,
                static_cast<unsigned long long>(f.triangles_in), static_cast<unsigned long long>(f.sites),
                static_cast<unsigned long long>(f.triangles_out), f.solid, f.diagram, f.fracture, whole,
                last_exponent(x, time), f.bytes / (1 << 20), last_exponent(x, memory),
                sound ? "" : "  NOT SOUND");
  }
  std::printf("  exponents: time %.2f, memory %.2f\n", exponent(x, time), exponent(x, memory));
  std::fflush(stdout);
  return right;
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream words(text);
  for (std::string word; std::getline(words, word, ',');) parts.push_back(word);
  return parts;
}

int main_of(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; i += 2) {
    const std::string name = argv[i], value = i + 1 < argc ? argv[i + 1] : "";
    if (value.empty()) {
      std::fprintf(stderr, "bench_growth: %s needs a value\n", name.c_str());
      return 2;
    }
    if (name == "--family") {
      options.families = split(value);
    } else if (name == "--sizes") {
      for (const std::string& s : split(value))
        options.sizes.push_back(static_cast<std::uint32_t>(std::strtoul(s.c_str(), nullptr, 10)));
    } else if (name == "--runs") {
      options.runs = std::max(1, static_cast<int>(std::strtol(value.c_str(), nullptr, 10)));
    } else if (name == "--limit") {
      options.limit = static_cast<unsigned>(std::max(1l, std::strtol(value.c_str(), nullptr, 10)));
    } else if (name == "--seed") {
      options.seed = std::strtoull(value.c_str(), nullptr, 10);
    } else if (name == "--program-label") {
      options.label = value;
    } else {
      std::fprintf(stderr, "bench_growth: there is no %s\n", name.c_str());
      return 2;
    }
  }
  const std::vector<Family> families = all_families();
  for (const std::string& name : options.families)
    if (std::none_of(families.begin(), families.end(), [&](const Family& f) { return name == f.name; })) {
      std::fprintf(stderr, "bench_growth: there is no family %s\n", name.c_str());
      return 2;
    }
  bool right = true;
  for (const Family& family : families) {
    const auto& wanted = options.families;
    if (wanted.empty() || std::find(wanted.begin(), wanted.end(), family.name) != wanted.end())
      right &= run(family, options);
  }
  return right ? 0 : 1;
}

}  // namespace
}  // namespace fracture::bench

int main(int argc, char** argv) { return fracture::bench::main_of(argc, argv); }
