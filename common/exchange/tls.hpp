// HTTPS for clients: which certificates to trust. The server's certificate and name are always verified.
#pragma once

#include <boost/asio/ssl/context.hpp>
#include <memory>
#include <string>

#include "common/base/error.hpp"

namespace fracture::protocol {

/// Certificates of trusted authorities, read once. Shared by connections.
struct TlsTrust {
  boost::asio::ssl::context context{boost::asio::ssl::context::tls_client};
};

/// Reads the certificates in a PEM file or, if `ca_file` is empty, those that this system trusts. Error:
/// kBadParameter if the file contains none.
Expected<std::shared_ptr<TlsTrust>> trust_in(const std::string& ca_file);

}  // namespace fracture::protocol
