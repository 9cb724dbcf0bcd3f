// Version of the bytes of a result.
#pragma once

namespace fracture {

/// The bytes of a result may change only if this number rises, because caches are keyed by it. CHANGELOG.md
/// says what each version changed. The test golden_bytes fails if bytes change without a new version.
inline constexpr int kAlgorithmVersion = 28;

}  // namespace fracture
