// Bearer tokens (RFC 6750), optional: who asks, and whether that name may. What each may is in the token file
// (server/tenants/token_file.hpp).
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "server/http/request_head.hpp"
#include "server/tenants/accounts.hpp"

namespace fracture::http {

using AccountPointer = std::shared_ptr<tenants::Account>;

/// Null when nobody is asked for a token. 401 for who shows none, a wrong one or one that has expired. `page`: browsers
/// get the page, which asks for the token itself.
OrProblem<AccountPointer> authenticate(const tenants::Accounts& accounts, const RequestHead& head, bool page);

/// Counts the request. 403 where the name's scopes do not hold what is asked (a path that is not there needs
/// none), 429 over its requests a second.
std::optional<Problem> refuse_caller(tenants::Account& account, const RequestHead& head);

/// Of a request that was let in as this account's and is not over: why it would be let in no more, because its token
/// was revoked, has expired, or has lost the scope meanwhile. Nothing: it may go on. Counts nothing.
std::optional<Problem> refuse_by_now(const tenants::Accounts& accounts, const RequestHead& head,
                                     const AccountPointer& account);

}  // namespace fracture::http
