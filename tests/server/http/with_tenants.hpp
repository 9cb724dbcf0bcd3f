// A server with a token file.
#pragma once

#include <vector>

#include "tests/server/support/tenant_file.hpp"
#include "tests/server/support/test_server.hpp"

namespace fracture::test {

inline TestServerOptions with_tenants(const std::vector<nlohmann::json>& tenants) {
  TestServerOptions options;
  options.server.tokens = *tenants::TokenFile::parse(tenant_file(tenants));
  return options;
}

}  // namespace fracture::test
