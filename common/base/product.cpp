#include "common/base/product.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "common/base/execution.hpp"
#include "common/base/words.hpp"

namespace fracture {
namespace {

constexpr std::uint64_t kMostAhead =
    64u << 20;  ///< bytes: a computation of 1 GiB asks its budget about twenty times

struct Refusal {
  ErrorCode code;
  std::string why;  ///< end of the sentence that says how much memory is needed
  std::string advice;
};

Refusal refusal_of(Allowance::Answer answer, const std::string& limit) {
  switch (answer) {
    case Allowance::Answer::kNever:
      return {ErrorCode::kTooComplex, "; the limit for one computation is " + limit, kAdviceForFewerProducts};
    case Allowance::Answer::kOverShare:
      return {ErrorCode::kOverShare,
              "; the limit for all computations of one client is " + limit +
                  ", and this client's other computations use the rest",
              "Send the request again when one of your other computations has finished."};
    default:
      return {ErrorCode::kOutOfMemory, ", but other computations are using too much memory now",
              "Try again later."};
  }
}

/// Returns "2,863,922 fragment triangles", or "a mesh of 36.7 MB".
std::string amount_of(Product product, std::uint64_t count) {
  switch (product) {
    case Product::kImportBytes:
      return "an import of " + data_size(count);
    case Product::kMeshBytes:
      return "a mesh of " + data_size(count);
    default:
      break;
  }
  std::string what = name_of(product);
  std::replace(what.begin(), what.end(), '_', ' ');
  return grouped(count) + " " + what;
}

}  // namespace

const char* name_of(Product product) {
  switch (product) {
    case Product::kTetrahedra:
      return "tetrahedra";
    case Product::kSurfaceTriangles:
      return "surface_triangles";
    case Product::kPolygons:
      return "polygons";
    case Product::kSegments:
      return "segments";
    case Product::kCapTriangles:
      return "cap_triangles";
    case Product::kFragmentTriangles:
      return "fragment_triangles";
    case Product::kImportBytes:
      return "import_bytes";
    case Product::kMeshBytes:
      return "mesh_bytes";
    case Product::kContacts:
      return "contacts";
  }
  return "";
}

std::uint64_t bytes_of(Product product) {
  switch (product) {
    case Product::kTetrahedra:
      return 160;
    case Product::kSurfaceTriangles:
      return 200;
    case Product::kPolygons:
      return 280;
    case Product::kSegments:
      return 64;
    case Product::kCapTriangles:
      return 150;
    case Product::kFragmentTriangles:
      return 220;
    case Product::kContacts:
      return 200;
    case Product::kImportBytes:
    case Product::kMeshBytes:
      return 1;
  }
  return 0;
}

void Allowance::add(Product product, std::uint64_t count) {
  if (count == 0) return;
  made_[static_cast<std::size_t>(product)].fetch_add(count, std::memory_order_relaxed);
  const std::uint64_t more = count * bytes_of(product);
  const std::uint64_t bytes = bytes_.fetch_add(more, std::memory_order_relaxed) + more;
  if (bytes > granted_.load(std::memory_order_relaxed)) grow(product, bytes);
}

void Allowance::shrink() {
  const std::uint64_t bytes = std::max(admitted_, this->bytes());
  if (!release_ || bytes >= granted_) return;
  release_(bytes);
  granted_ = bytes;
}

void Allowance::grow(Product product, std::uint64_t bytes) {
  // Ask for half as much again, so that the budget is asked only a few times. If that is refused, ask for the minimum. A large
  // computation asks for little more than it needs, because others may need the rest.
  const std::uint64_t ahead = std::min(bytes / 2, kMostAhead);
  Answer answer = Answer::kNotNow;
  for (const std::uint64_t wanted : {std::min(bytes + ahead, std::max(limit_, bytes)), bytes}) {
    answer = grant_(wanted);
    if (answer != Answer::kGranted) continue;
    std::uint64_t granted = granted_.load();
    while (granted < wanted && !granted_.compare_exchange_weak(granted, wanted)) {
    }
    return;
  }
  const Refusal refusal = refusal_of(answer, data_size(limit_));
  const std::uint64_t made = made_[static_cast<std::size_t>(product)].load();
  Error error{refusal.code, "This computation needs more than " + data_size(bytes) + " of memory" +
                                refusal.why + ". By then, it had made " + amount_of(product, made) + ". " +
                                refusal.advice};
  if (refusal.code == ErrorCode::kOverShare) error.retry_after = std::chrono::seconds(10);
  error.extra = Figures(
      nlohmann::json{{"grew", name_of(product)}, {"count", made}, {"bytes", bytes}, {"limit", limit_}});
  throw Interrupted(std::move(error));
}

}  // namespace fracture
