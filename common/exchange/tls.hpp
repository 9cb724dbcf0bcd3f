// HTTPS from the side of who asks: whom to believe. The certificate is always checked, with its name.
#pragma once

#include <boost/asio/ssl/context.hpp>
#include <memory>
#include <string>

#include "common/base/error.hpp"

namespace fracture::protocol {

/// Certificates of those who may sign a server's, read once. Shared by connections.
struct TlsTrust {
  boost::asio::ssl::context context{boost::asio::ssl::context::tls_client};
};

/// Those in a PEM file, or where it is empty those that this system trusts. kBadParameter: the file holds
/// none.
Expected<std::shared_ptr<TlsTrust>> trust_in(const std::string& ca_file);

}  // namespace fracture::protocol
