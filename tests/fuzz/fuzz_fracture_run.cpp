// fuzz_fracture without libFuzzer, in every build: random inputs from a seed, one after the other, for hours.
//
//   fuzz_fracture_run [--seed S] [--from K] [--count N] [--time SECONDS] [--failures FOLDER]
//   fuzz_fracture_run --input HEX | --file FILE  [--obj FILE]
//
// Input k of a seed is always the same bytes. Inputs run in a child process. An input may end it by a broken
// invariant (which aborts), by a crash or after --limit seconds. It is then counted, its bytes are kept in
// FOLDER, and the next child continues after it. --input and --file run a single input in this process. --obj
// writes its mesh and prints its parameters instead. Exits with 0 if nothing failed, otherwise with 1.
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <new>
#include <string>
#include <vector>

#include "common/base/random.hpp"
#include "tests/fuzz/fracture_case.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace fracture::fuzz {

std::string& last_outcome();

namespace {

using Input = std::vector<std::uint8_t>;

struct Options {
  std::uint64_t seed = 1, from = 0, count = UINT64_MAX;
  double seconds = 60;
  unsigned limit = 300;
  std::string failures, obj;
  Input input;
  bool one = false;
};

/// Memory that children and parent share.
struct Shared {
  std::atomic<std::uint64_t> next;  ///< the running input
  struct Count {
    char word[40];
    std::uint64_t times;
  } outcomes[40];

  void count(const std::string& word) {
    for (Count& c : outcomes) {
      if (c.times > 0 && word.compare(0, sizeof c.word - 1, c.word) != 0) continue;
      std::snprintf(c.word, sizeof c.word, "%s", word.c_str());
      ++c.times;
      return;
    }
  }
};

Input input_of(std::uint64_t seed, std::uint64_t k) {
  Random random(seed * 0x9e3779b97f4a7c15ull ^ k * 0xbf58476d1ce4e5b9ull);
  Input input(24 + random.below(600));
  for (std::uint8_t& byte : input) byte = static_cast<std::uint8_t>(random());
  return input;
}

std::string hex(const Input& input) {
  std::string text;
  char digits[3];
  for (const std::uint8_t byte : input) {
    std::snprintf(digits, sizeof digits, "%02x", byte);
    text += digits;
  }
  return text;
}
Input from_hex(const std::string& text) {
  Input input;
  for (std::size_t k = 0; k + 1 < text.size(); k += 2)
    input.push_back(static_cast<std::uint8_t>(std::strtoul(text.substr(k, 2).c_str(), nullptr, 16)));
  return input;
}

int run_one(const Options& options) {
  if (!options.obj.empty()) {
    const FractureCase c = decode_case(options.input.data(), options.input.size());
    std::ofstream(options.obj) << to_obj(c.mesh);
    std::printf("%s\n%s\n", c.shape.c_str(), c.request.dump().c_str());
    return 0;
  }
  LLVMFuzzerTestOneInput(options.input.data(), options.input.size());
  std::printf("%s\n", last_outcome().c_str());
  return 0;
}

int run_many(const Options& options) {
  void* memory = ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return 1;
  auto* shared = new (memory) Shared{};
  shared->next = options.from;
  if (!options.failures.empty()) std::filesystem::create_directories(options.failures);
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(options.seconds);
  const std::uint64_t last =
      options.count > UINT64_MAX - options.from ? UINT64_MAX : options.from + options.count;
  std::uint64_t failed = 0;
  const auto wanted = [&] { return shared->next < last && std::chrono::steady_clock::now() < end; };
  while (wanted()) {
    const pid_t child = ::fork();
    if (child < 0) return 1;
    if (child == 0) {
      for (; wanted(); ++shared->next) {
        const Input input = input_of(options.seed, shared->next);
        ::alarm(options.limit);
        LLVMFuzzerTestOneInput(input.data(), input.size());
        shared->count(last_outcome());
      }
      ::_exit(0);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) continue;
    ++failed;
    const std::uint64_t k = shared->next++;
    const Input input = input_of(options.seed, k);
    const bool late = WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM;
    shared->count(late ? "FAILED: took too long" : "FAILED");
    std::fprintf(stderr, "FAILED: seed %llu, input %llu (%s)\n",
                 static_cast<unsigned long long>(options.seed), static_cast<unsigned long long>(k),
                 WIFSIGNALED(status) ? ::strsignal(WTERMSIG(status)) : "ended by itself");
    if (late) std::fprintf(stderr, "repeat: fuzz_fracture_run --input %s\n", hex(input).c_str());
    if (!options.failures.empty()) {
      std::ofstream file(options.failures + "/" + std::to_string(options.seed) + "-" + std::to_string(k),
                         std::ios::binary);
      file.write(reinterpret_cast<const char*>(input.data()), static_cast<std::streamsize>(input.size()));
    }
  }
  for (const Shared::Count& c : shared->outcomes)
    if (c.times > 0) std::printf("%9llu %s\n", static_cast<unsigned long long>(c.times), c.word);
  std::printf("%llu inputs of seed %llu from %llu: %llu failed\n",
              static_cast<unsigned long long>(shared->next - options.from),
              static_cast<unsigned long long>(options.seed), static_cast<unsigned long long>(options.from),
              static_cast<unsigned long long>(failed));
  return failed == 0 ? 0 : 1;
}

int main_of(int argc, char** argv) {
  Options options;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string name = argv[i], value = argv[i + 1];
    if (name == "--seed") {
      options.seed = std::strtoull(value.c_str(), nullptr, 10);
    } else if (name == "--from") {
      options.from = std::strtoull(value.c_str(), nullptr, 10);
    } else if (name == "--count") {
      options.count = std::strtoull(value.c_str(), nullptr, 10);
      options.seconds = 1e9;
    } else if (name == "--time") {
      options.seconds = std::strtod(value.c_str(), nullptr);
    } else if (name == "--limit") {
      options.limit = static_cast<unsigned>(std::strtoul(value.c_str(), nullptr, 10));
    } else if (name == "--failures") {
      options.failures = value;
    } else if (name == "--obj") {
      options.obj = value;
    } else if (name == "--input") {
      options.input = from_hex(value);
      options.one = true;
    } else if (name == "--file") {
      std::ifstream file(value, std::ios::binary);
      options.input.assign(std::istreambuf_iterator<char>(file), {});
      options.one = true;
    } else {
      std::fprintf(stderr, "fuzz_fracture_run: there is no %s\n", name.c_str());
      return 2;
    }
  }
  return options.one ? run_one(options) : run_many(options);
}

}  // namespace
}  // namespace fracture::fuzz

int main(int argc, char** argv) { return fracture::fuzz::main_of(argc, argv); }
