#include "server/http/auth.hpp"

#include <chrono>
#include <utility>

#include "server/http/api.hpp"
#include "server/http/prefer.hpp"
#include "server/http/routes.hpp"

namespace fracture::http {
namespace {

using tenants::Scope;
using tenants::Scopes;

constexpr const char* kInvalid = "Bearer realm=\"fracture\", error=\"invalid_token\"";

Problem unauthorized(std::string detail, const char* challenge) {
  return Problem(HttpProblem::kUnauthorized, std::move(detail)).with("WWW-Authenticate", challenge);
}

/// Returns the scopes that allow this operation; any one is enough. Empty: no scope is needed.
Scopes needed(Operation operation, const RequestHead& head) {
  switch (operation) {
    case Operation::kGetIndex:
    case Operation::kGetLlms:
    case Operation::kGetDocs:
    case Operation::kGetPageFile:
    case Operation::kGetVersion:
    case Operation::kGetLimits:
    case Operation::kGetPatterns:
    case Operation::kGetOpenapi:
    case Operation::kGetProblem:
    case Operation::kGetLivez:
    case Operation::kGetReadyz:
    case Operation::kGetMetrics:
      return {};
    case Operation::kGetFracture:
    case Operation::kGetMesh:
    case Operation::kGetJob:
    case Operation::kGetJobs:
    case Operation::kGetJobEvents:
      return {Scope::kRead};
    case Operation::kPostFracture:
    case Operation::kPostMeshFracture:
      return {preferences_of(head).respond_async ? Scope::kBake : Scope::kFracture};
    case Operation::kPostMesh:
    case Operation::kPutMesh:
    case Operation::kPostMeshEstimate:
      return {Scope::kFracture, Scope::kBake};
    case Operation::kDeleteMesh:
      return {Scope::kFracture, Scope::kBake, Scope::kAdmin};
    case Operation::kDeleteJob:
      return {Scope::kBake, Scope::kAdmin};
  }
  return {Scope::kAdmin};
}

std::string names_of(Scopes scopes) {
  constexpr std::pair<Scope, const char*> kNames[] = {{Scope::kRead, "read"},
                                                      {Scope::kFracture, "fracture"},
                                                      {Scope::kBake, "bake"},
                                                      {Scope::kAdmin, "admin"}};
  std::string names;
  for (const auto& [scope, name] : kNames)
    if (scopes.has(scope)) names.append(names.empty() ? "" : " ").append(name);
  return names;
}

/// Returns null if the public listener has no such route.
const Route* route_of(const RequestHead& head) {
  for (const Route& route : routes())
    if (route.listener == Listener::kPublic && match(route, head.path) &&
        (route.method == head.method || (head.method == "HEAD" && route.method == "GET")))
      return &route;
  return nullptr;
}

}  // namespace

OrProblem<AccountPointer> authenticate(const tenants::Accounts& accounts, const RequestHead& head,
                                       bool page) {
  if (accounts.open()) return AccountPointer();
  const Route* const route = route_of(head);
  // The pages about problems are public, including the one about 401.
  if (route && route->operation == Operation::kGetProblem) return AccountPointer();
  if (route && page && is_page(route->operation, head)) return AccountPointer();
  const std::string given = head.field("authorization");
  constexpr std::string_view kScheme = "Bearer ";
  if (given.size() <= kScheme.size() ||
      !equals_ignoring_case(std::string_view(given).substr(0, kScheme.size()), kScheme))
    return tl::unexpected<Problem>(unauthorized(
        "This server needs a token: send 'Authorization: Bearer <token>'.", "Bearer realm=\"fracture\""));
  tenants::Accounts::Found found = accounts.find(std::string_view(given).substr(kScheme.size()));
  if (!found.account)
    return tl::unexpected<Problem>(unauthorized(
        "This server does not know the token. Check it, or ask the administrator for a valid one.",
        kInvalid));
  if (found.expires &&
      std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now()) >= *found.expires)
    return tl::unexpected<Problem>(
        unauthorized("The token has expired. Ask the administrator for a new one.", kInvalid));
  return std::move(found.account);
}

namespace {

std::optional<Problem> refuse_scope(const tenants::Account& account, const RequestHead& head) {
  const Route* const route = route_of(head);
  if (!route) return std::nullopt;  // refused later as not found
  const Scopes wanted = needed(route->operation, head);
  const std::string names = names_of(wanted);
  if (names.empty() || account.scopes().has_any(wanted)) return std::nullopt;
  return Problem(HttpProblem::kForbidden,
                 "This token's scopes do not allow this request. Use a token with one of these scopes: " +
                     names + ".")
      .with("WWW-Authenticate",
            "Bearer realm=\"fracture\", error=\"insufficient_scope\", scope=\"" + names + "\"");
}

}  // namespace

std::optional<Problem> refuse_caller(tenants::Account& account, const RequestHead& head) {
  if (std::optional<Error> over = account.request()) return to_problem(std::move(*over));
  return refuse_scope(account, head);
}

std::optional<Problem> refuse_by_now(const tenants::Accounts& accounts, const RequestHead& head,
                                     const AccountPointer& account) {
  if (!account) return std::nullopt;
  const OrProblem<AccountPointer> now = authenticate(accounts, head, false);
  if (!now) return now.error();
  if (*now != account) return unauthorized("The token now belongs to another name.", kInvalid);
  return refuse_scope(*account, head);
}

}  // namespace fracture::http
