// The version of the bytes of an answer.
#pragma once

namespace fracture {

/// The bytes of an answer to a request change only if this number rises. Caches are keyed by it. CHANGELOG.md says for
/// each version what it changed; the test golden_bytes finds a change of bytes that did not raise it.
inline constexpr int kAlgorithmVersion = 25;

}  // namespace fracture
