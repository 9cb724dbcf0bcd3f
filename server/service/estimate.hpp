// Estimates an answer and the memory of its computation before anything is computed. The estimate follows from the parameters and a few
// figures of the solid and its parts. admission.cpp reserves memory by it, and the service refuses requests by it that cannot fit.
// POST /meshes/{id}/estimate returns it. A Solid converts to SolidFigures; several estimates with the same ones share their work. All
// functions throw Interrupted, as the execution of the SolidFigures says.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/base/error.hpp"
#include "common/parameters/parameters.hpp"
#include "server/service/solid_figures.hpp"

namespace fracture {

/// Expected numbers. estimate_test.cpp compares them with real answers: they are within a factor of two.
struct ExpectedAnswer {
  double sites = 0, fragments = 0;
  double triangles = 0;   ///< of all fragments
  double file_bytes = 0;  ///< of the GLB
  /// The most that an Allowance counts at once (common/base/product.hpp), without the solid's products.
  double working_bytes = 0;
};

/// Estimates the whole answer. Hits cut the pieces that are there (estimate_of_hits.hpp). The parts of one fragment count as further
/// sites. A solid without parts gives zeros.
ExpectedAnswer expected_answer(const RequestParameters& asked, const SolidFigures& solid);
/// Returns only ExpectedAnswer::working_bytes.
double expected_working_bytes(const FractureParameters& parameters, const SolidFigures& solid,
                              const Selection& selection = {});

/// The parameter that costs most memory, and what leaving it out would save.
struct CostliestParameter {
  std::string name;          ///< empty: the mesh itself costs most
  nlohmann::json value;      ///< that would cost less: 0, false, or the largest count that fits
  double working_bytes = 0;  ///< with that value
};
/// `limit`: bytes that the computation may hold.
CostliestParameter costliest_parameter(const RequestParameters& asked, const SolidFigures& solid,
                                       double limit);

/// The setting that limits the memory of a computation on a server.
inline constexpr const char* kWorkingSetting = "--max-working";

/// Returns the sentence that says what to change: "Most of the memory is for 'rough_amplitude': …". `setting`: what to raise
/// instead.
std::string advice_for_less_memory(const RequestParameters& asked, const SolidFigures& solid, double limit,
                                   const std::string& setting = kWorkingSetting);

/// An estimate may be twice the real number. So a request is refused only if its estimate is more than this many times the limit.
inline constexpr double kEstimateFactor = 2;

/// Whether cannot_fit() returns nothing. Takes one evaluation, without advice.
bool fits(const RequestParameters& asked, const SolidFigures& solid, std::uint64_t limit);

/// Refuses a request that cannot fit into `limit` bytes (kTooComplex). Requests that start from a kept answer are never refused,
/// because they make only its changes.
std::optional<Error> cannot_fit(const RequestParameters& asked, const SolidFigures& solid,
                                std::uint64_t limit, const std::string& setting = kWorkingSetting);

/// Returns {sites, fragments, triangles, bytes, working_bytes, limit_bytes, fits, costliest, advice}: the body of
/// POST /meshes/{id}/estimate. `limit`: 0: none, and limit_bytes is null. `advice` is null only if working_bytes is within the
/// limit. `fits` is false only if the request would be refused before its diagram is made.
nlohmann::json estimate_document(const RequestParameters& asked, const SolidFigures& solid,
                                 std::uint64_t limit, const std::string& setting = kWorkingSetting);

/// Replaces the advice of an error kTooComplex that a computation ended with; other errors stay as they are.
Error with_advice(Error error, const RequestParameters& asked, const SolidFigures& solid,
                  const std::string& setting = kWorkingSetting);

}  // namespace fracture
