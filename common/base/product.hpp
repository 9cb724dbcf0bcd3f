// Counts the products of a computation while they are made, because the size of an answer is known only at
// its end.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>

#include "common/base/error.hpp"

namespace fracture {

/// Products whose number depends on both the mesh and the sites.
enum class Product {
  kTetrahedra,         ///< of the sites
  kSurfaceTriangles,   ///< of the solid, including repairs
  kPolygons,           ///< triangle ∩ cell
  kSegments,           ///< of the caps' outlines
  kCapTriangles,       ///< including those of rough caps
  kFragmentTriangles,  ///< as written to the answer
  kImportBytes,        ///< of the process that reads a file, and of its result
  kMeshBytes,          ///< of the imported mesh
  kContacts,           ///< pairs of parts in contact
};
inline constexpr std::size_t kProducts = 9;
const char* name_of(Product product);
/// Peak bytes for one of them, including its vertices, its indices and the tables of the stage that makes it.
/// common/pipeline/DECISION.md has the measurements.
std::uint64_t bytes_of(Product product);

/// The advice of a refusal (kTooComplex) that only counts products. Callers that know the request may give better advice.
inline constexpr const char* kAdviceForFewerProducts =
    "Ask for fewer sites, or send a mesh with fewer triangles.";

/// The number of bytes that one computation may hold for its products. Thread-safe.
class Allowance {
 public:
  enum class Answer {
    kGranted,
    kNotNow,     ///< other computations hold the missing memory
    kOverShare,  ///< other computations of the same client hold the missing memory
    kNever,      ///< exceeds the maximum for any single computation
  };
  /// Returns whether the computation may hold this many bytes in all. Rarely called, because each request asks for half as much
  /// again, or for 64 MiB more if that is less.
  using Grant = std::function<Answer(std::uint64_t bytes)>;
  /// From now on, the computation holds no more than this many bytes.
  using Release = std::function<void(std::uint64_t bytes)>;

  /// `granted`: bytes that the computation already holds. `limit`: the most that `grant` can ever grant, for error
  /// messages.
  Allowance(std::uint64_t granted, std::uint64_t limit, Grant grant, Release release = {})
      : granted_(granted),
        admitted_(granted),
        limit_(limit),
        grant_(std::move(grant)),
        release_(std::move(release)) {}
  Allowance(const Allowance&) = delete;
  Allowance& operator=(const Allowance&) = delete;

  /// Counts further products. Throws Interrupted: kTooComplex, with the kind of product, if the computation could
  /// never hold them; kOutOfMemory if other clients are using the memory now; kOverShare if the same client is using
  /// it.
  void add(Product product, std::uint64_t count);
  /// The number of products counted, including those of a Temporary.
  std::uint64_t made(Product product) const {
    return made_[static_cast<std::size_t>(product)].load(std::memory_order_relaxed);
  }
  /// Maximum number of bytes that the computation could ever hold.
  std::uint64_t limit() const { return limit_; }
  std::uint64_t bytes() const { return bytes_.load(std::memory_order_relaxed); }
  /// The most bytes that were counted at once. Not to be called while another thread ends a Temporary.
  std::uint64_t most_bytes() const { return std::max(most_, bytes()); }

  /// Lets other computations use the memory that was granted to a step that has ended (a Temporary), except
  /// for the initial grant. No other thread may count for the same computation at the same time.
  void shrink();

  /// Products counted between its construction and its destruction are gone afterwards. Null: does nothing.
  /// No other thread may count for the same computation at either moment.
  class Temporary {
   public:
    explicit Temporary(Allowance* allowance)
        : allowance_(allowance), before_(allowance ? allowance->bytes() : 0) {}
    ~Temporary() {
      if (!allowance_) return;
      allowance_->most_ = allowance_->most_bytes();
      allowance_->bytes_.store(before_, std::memory_order_relaxed);
    }
    Temporary(const Temporary&) = delete;
    Temporary& operator=(const Temporary&) = delete;

   private:
    Allowance* const allowance_;
    const std::uint64_t before_;
  };

 private:
  void grow(Product product, std::uint64_t bytes);

  std::atomic<std::uint64_t> bytes_{0}, granted_;
  std::uint64_t most_ = 0;  // before the last Temporary ended
  const std::uint64_t admitted_, limit_;
  const Grant grant_;
  const Release release_;
  std::atomic<std::uint64_t> made_[kProducts]{};
};

}  // namespace fracture
