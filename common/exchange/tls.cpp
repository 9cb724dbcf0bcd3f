#include "common/exchange/tls.hpp"

#include <openssl/ssl.h>

namespace fracture::protocol {

Expected<std::shared_ptr<TlsTrust>> trust_in(const std::string& ca_file) {
  auto trust = std::make_shared<TlsTrust>();
  boost::system::error_code error;
  SSL_CTX_set_min_proto_version(trust->context.native_handle(), TLS1_2_VERSION);
  trust->context.set_verify_mode(boost::asio::ssl::verify_peer);
  if (ca_file.empty())
    trust->context.set_default_verify_paths(error);
  else
    trust->context.load_verify_file(ca_file, error);
  if (error)
    return fail(ErrorCode::kBadParameter,
                "The file " + ca_file + " contains no readable certificates: " + error.message() + ".");
  return trust;
}

}  // namespace fracture::protocol
