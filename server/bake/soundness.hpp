// Whether an answer proves itself: only such an answer is written.
#pragma once

#include "server/service/service.hpp"

namespace fracture::bake {

/// Does the certificate of an answer hold: nothing open, and (but for dual=barycenter) every cap mirrored and
/// nothing lost? The baker refuses what does not prove itself; this is the second line, also for the answers of
/// older servers.
bool is_sound(const AnswerSummary& summary);

/// kUnsound with the figures of the certificate, for an answer that does not.
Error unsound(const Certificate& certificate);

}  // namespace fracture::bake
