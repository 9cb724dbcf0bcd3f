// Every name's account, under the token file that is in force; another file can take its place while requests
// are answered.
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

  /// From now on this file decides. Names that stay keep their accounts and what those have used.
  void replace(TokenFile file);

  /// Nobody is asked for a token.
  bool open() const;

  struct Found {
    std::shared_ptr<Account> account;  ///< null: nobody's token
    std::optional<std::chrono::sys_seconds> expires;
  };
  Found find(std::string_view token) const;

  /// By name. Accounts of names that the file no longer has are among them while something uses them.
  std::vector<std::shared_ptr<Account>> all() const;

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<const TokenFile> file_;
  std::map<std::string, std::shared_ptr<Account>> accounts_;
};

}  // namespace fracture::tenants
