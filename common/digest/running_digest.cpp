#include "common/digest/running_digest.hpp"

#include <openssl/evp.h>

#include "common/base/error.hpp"

namespace fracture {

struct RunningDigest::State {
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context{EVP_MD_CTX_new(), &EVP_MD_CTX_free};

  static void check(bool good) {
    if (!good) throw InternalError("a digest cannot be computed");
  }
};

RunningDigest::RunningDigest() : state_(std::make_unique<State>()) {
  State::check(state_->context && EVP_DigestInit_ex(state_->context.get(), EVP_sha256(), nullptr) == 1);
}
RunningDigest::~RunningDigest() = default;
RunningDigest::RunningDigest(RunningDigest&&) noexcept = default;
RunningDigest& RunningDigest::operator=(RunningDigest&&) noexcept = default;

void RunningDigest::add(std::span<const std::byte> bytes) {
  State::check(EVP_DigestUpdate(state_->context.get(), bytes.data(), bytes.size()) == 1);
}

Digest RunningDigest::finish() {
  Digest digest;
  State::check(EVP_DigestFinal_ex(state_->context.get(), digest.bytes.data(), nullptr) == 1);
  return digest;
}

}  // namespace fracture
