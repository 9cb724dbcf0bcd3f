// Optional bearer tokens (RFC 6750): identifies the caller and checks what it may do. The permissions are in
// the token file (server/tenants/token_file.hpp).
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "server/http/request_head.hpp"
#include "server/tenants/accounts.hpp"

namespace fracture::http {

using AccountPointer = std::shared_ptr<tenants::Account>;

/// Returns the account of the request's token, or null if none is required. Returns 401 if the token is
/// missing, wrong or expired. `page`: browsers get the page without a token, because the page asks for it.
OrProblem<AccountPointer> authenticate(const tenants::Accounts& accounts, const RequestHead& head, bool page);

/// Counts the request and checks its limits. Returns 403 if the name's scopes do not allow it (unknown paths
/// need none), and 429 if the name exceeds its requests per second.
std::optional<Problem> refuse_caller(tenants::Account& account, const RequestHead& head);

/// Checks again a request that was admitted for this account and has not ended. Returns the refusal if its
/// token was revoked, has expired or has lost the scope, else nothing. Counts nothing.
std::optional<Problem> refuse_by_now(const tenants::Accounts& accounts, const RequestHead& head,
                                     const AccountPointer& account);

}  // namespace fracture::http
