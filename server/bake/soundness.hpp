// Checks the certificate of an answer. Only answers that pass are written.
#pragma once

#include "server/service/service.hpp"

namespace fracture::bake {

/// Returns whether the certificate holds: no open edges and, except for dual=barycenter, every cap mirrored
/// and no volume lost. The baker already refuses such answers. This second check also covers answers of older
/// servers.
bool is_sound(const AnswerSummary& summary);

/// Returns kUnsound with the numbers of the certificate that does not hold.
Error unsound(const Certificate& certificate);

}  // namespace fracture::bake
