// The accounts of all names in the current token file. The file can be replaced while requests are being answered.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "server/tenants/account.hpp"
#include "server/tenants/token_file.hpp"

namespace fracture::tenants {

/// Thread-safe.
class Accounts {
 public:
  explicit Accounts(TokenFile file) { replace(std::move(file)); }

  /// Replaces the token file. Names that are still in the file keep their accounts and their used amounts.
  void replace(TokenFile file);

  /// Returns whether the server asks nobody for a token.
  bool open() const;

  struct Found {
    std::shared_ptr<Account> account;  ///< null: the token is unknown
    std::optional<std::chrono::sys_seconds> expires;
  };
  Found find(std::string_view token) const;

  /// Returns all accounts in the order of their names. An account whose name is no longer in the file is included while it is
  /// in use.
  std::vector<std::shared_ptr<Account>> all() const;

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<const TokenFile> file_;
  std::map<std::string, std::shared_ptr<Account>> accounts_;
};

}  // namespace fracture::tenants
