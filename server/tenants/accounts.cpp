#include "server/tenants/accounts.hpp"

#include <set>
#include <utility>

namespace fracture::tenants {

void Accounts::replace(TokenFile file) {
  const std::lock_guard lock(mutex_);
  std::set<std::string> names;
  for (const Tenant& tenant : file.tenants()) {
    names.insert(tenant.name);
    std::shared_ptr<Account>& account = accounts_[tenant.name];
    if (account)
      account->configure(tenant, file.isolated());
    else
      account = std::make_shared<Account>(tenant, file.isolated());
  }
  std::erase_if(accounts_, [&](const auto& entry) {
    return !names.contains(entry.first) && entry.second.use_count() == 1;
  });
  file_ = std::make_shared<const TokenFile>(std::move(file));
}

bool Accounts::open() const {
  const std::lock_guard lock(mutex_);
  return file_->empty();
}

Accounts::Found Accounts::find(std::string_view token) const {
  for (;;) {
    std::shared_ptr<const TokenFile> file;
    {
      const std::lock_guard lock(mutex_);
      file = file_;
    }
    const TokenFile::Match match = file->find(token);
    const std::lock_guard lock(mutex_);
    if (file != file_) continue;  // the file was replaced in the meantime, so the new one decides
    if (!match.tenant) return {};
    return {accounts_.at(match.tenant->name), match.token->expires};
  }
}

std::vector<std::shared_ptr<Account>> Accounts::all() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::shared_ptr<Account>> accounts;
  accounts.reserve(accounts_.size());
  for (const auto& [name, account] : accounts_) accounts.push_back(account);
  return accounts;
}

}  // namespace fracture::tenants
