#include "server/bake/soundness.hpp"

#include <cstdio>

#include "common/gltf/report_text.hpp"

namespace fracture::bake {
namespace {

constexpr double kMaxRelativeError = 1e-9;

}  // namespace

bool is_sound(const AnswerSummary& summary) {
  const Certificate& certificate = summary.certificate;
  if (certificate.open_edges != 0) return false;
  if (!summary.partition) return true;
  // `judged` means that the server has counted the mirrored caps and has already checked the volumes, with
  // tighter bounds than the certificate allows.
  if (summary.judged) return certificate.unmirrored_caps == 0;
  return certificate.relative_error <= kMaxRelativeError;
}

Error unsound(const Certificate& c) {
  char detail[300];
  std::snprintf(
      detail, sizeof detail,
      "The certificate does not hold: %llu open edges, %llu caps without a mirror image, input volume %.9g m³, "
      "output volume %.9g m³, relative error %.2g. Nothing was written.",
      static_cast<unsigned long long>(c.open_edges), static_cast<unsigned long long>(c.unmirrored_caps),
      c.volume_in, c.volume_out, c.relative_error);
  return {ErrorCode::kUnsound, detail, {}, Figures(certificate_document(c))};
}

}  // namespace fracture::bake
