// The shares of a name, by a clock that the test moves.
#include "server/tenants/account.hpp"

#include <gmock/gmock.h>
#include <malloc.h>

#include <list>

#include "common/digest/digest.hpp"
#include "server/tenants/accounts.hpp"
#include "server/tenants/ledger.hpp"

namespace fracture::tenants {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

const Account::Clock::time_point kStart{seconds(1000)};

std::shared_ptr<Account> account(const Shares& shares, Scopes scopes = {}, bool isolated = true) {
  return std::make_shared<Account>(Tenant{"studio", {}, scopes, shares}, isolated);
}

TEST(Account, RequestsOverTheRateAreRefusedAndSaidWhenToComeBack) {
  Shares shares;
  shares.requests_per_second = 4;
  const auto studio = account(shares);
  for (int k = 0; k < 4; ++k) EXPECT_FALSE(studio->request(kStart)) << k;
  const auto over = studio->request(kStart);
  ASSERT_TRUE(over);
  EXPECT_EQ(over->retry_after, seconds(1)) << "a quarter of a second, in whole ones";
  EXPECT_THAT(over->detail, testing::HasSubstr("4 requests a second"));
  EXPECT_FALSE(studio->request(kStart + milliseconds(250)));
  EXPECT_TRUE(studio->request(kStart + milliseconds(251)));
  for (int k = 0; k < 4; ++k) EXPECT_FALSE(studio->request(kStart + seconds(60))) << "never more at once";
  EXPECT_TRUE(studio->request(kStart + seconds(60)));
  EXPECT_EQ(studio->figures().requests, 12u);
  EXPECT_EQ(studio->figures().over_share, 3u);
}

TEST(Account, ARateBelowOneASecondWaitsAsLongAsItSays) {
  Shares shares;
  shares.requests_per_second = 0.1;
  const auto studio = account(shares);
  EXPECT_FALSE(studio->request(kStart));
  EXPECT_EQ(studio->request(kStart)->retry_after, seconds(10));
  EXPECT_FALSE(studio->request(kStart + seconds(10)));
}

TEST(Account, TheFieldsSayWhatIsLeft) {
  EXPECT_TRUE(account({})->rate_fields(kStart).empty());
  Shares shares;
  shares.requests_per_second = 4;
  const auto studio = account(shares);
  studio->request(kStart);
  EXPECT_THAT(studio->rate_fields(kStart),
              testing::ElementsAre(testing::Pair("RateLimit-Policy", "\"requests\";q=4;w=1"),
                                   testing::Pair("RateLimit", "\"requests\";r=3;t=1")));
  shares.cores = 0.5;
  studio->configure({"studio", {}, {}, shares}, true);
  studio->charge(2, kStart);
  EXPECT_EQ(studio->rate_fields(kStart)[0].second, "\"requests\";q=4;w=1, \"processor-ms\";q=5000;w=10");
  EXPECT_EQ(studio->rate_fields(kStart)[1].second, "\"requests\";r=3;t=1, \"processor-ms\";r=3000;t=4");
}

TEST(Account, ComputationsAtTheSameTimeAreCountedUntilTheyEnd) {
  Shares shares;
  shares.computations = 2;
  const auto studio = account(shares);
  std::list<Account::Seat> seats;
  for (int k = 0; k < 2; ++k) {
    auto seat = studio->begin_computation(kStart);
    ASSERT_TRUE(seat);
    seats.push_back(std::move(*seat));
  }
  EXPECT_EQ(studio->figures().computations, 2u);
  const auto over = studio->begin_computation(kStart);
  ASSERT_FALSE(over);
  EXPECT_THAT(over.error().detail, testing::HasSubstr("2 computations"));
  seats.pop_front();
  EXPECT_TRUE(studio->begin_computation(kStart));
}

TEST(Account, MeasuredProcessorSecondsArePaidBack) {
  Shares shares;
  shares.cores = 0.5;  // five seconds at once
  const auto studio = account(shares);
  EXPECT_TRUE(studio->begin_computation(kStart));
  studio->charge(8, kStart);  // the cost was not known before
  const auto over = studio->begin_computation(kStart);
  ASSERT_FALSE(over);
  EXPECT_EQ(over.error().retry_after, seconds(7)) << "three seconds at half a core, and a little";
  EXPECT_FALSE(studio->begin_computation(kStart + seconds(6)));
  EXPECT_TRUE(studio->begin_computation(kStart + seconds(7)));
  EXPECT_DOUBLE_EQ(studio->figures().processor_seconds, 8);
}

TEST(Account, WhoIsOverItsProcessorRateIsSoUntilItHasComeTogetherAgain) {
  Shares shares;
  shares.cores = 0.5;  // five seconds at once
  const auto studio = account(shares);
  studio->charge(4.9, kStart);
  EXPECT_FALSE(studio->is_over_processor_rate(kStart));
  studio->charge(1.1, kStart);
  EXPECT_TRUE(studio->is_over_processor_rate(kStart + seconds(2)));
  EXPECT_FALSE(studio->is_over_processor_rate(kStart + milliseconds(2001)));
  const auto boundless = account({});
  boundless->charge(1e9, kStart);
  EXPECT_FALSE(boundless->is_over_processor_rate(kStart)) << "it has no rate";
}

TEST(Account, SeesItsOwnAnAdministratorAllAndWhoSharesEverything) {
  EXPECT_TRUE(account({})->sees("studio"));
  EXPECT_FALSE(account({})->sees("other"));
  EXPECT_FALSE(account({})->sees("")) << "what was there before names were";
  EXPECT_TRUE(account({}, {Scope::kAdmin})->sees("other"));
  EXPECT_TRUE(account({}, {}, false)->sees("other"));
  EXPECT_EQ(account({})->owner(), "studio");
  EXPECT_EQ(account({}, {}, false)->owner(), "");
}

#ifndef FRACTURE_SANITIZED  // The sanitizers' allocator counts differently.
TEST(AnswerLedger, AnEntryTakesNoMoreThanItSays) {
  constexpr std::uint64_t kEntries = 20'000;
  AnswerLedger ledger(kEntries * AnswerLedger::kBytesPerEntry);
  const std::size_t before = ::mallinfo2().uordblks;
  for (std::uint64_t k = 0; k < kEntries; ++k)
    EXPECT_TRUE(ledger.add("ana", sha256(std::to_string(k)).hex(), 1, UINT64_MAX).empty());
  const std::size_t held = ::mallinfo2().uordblks - before;
  EXPECT_LE(held, ledger.held_bytes());
  EXPECT_GT(held, ledger.held_bytes() / 2) << "not much less either";
  EXPECT_EQ(ledger.add("bob", sha256("another").hex(), 1, UINT64_MAX).size(), 1u);
  EXPECT_EQ(ledger.held_bytes(), kEntries * AnswerLedger::kBytesPerEntry);
}
#endif

TEST(AnswerLedger, ANameWithoutAnswersIsForgotten) {
  AnswerLedger none(0);
  EXPECT_EQ(none.add("ana", "a", 1, 10), std::vector<std::string>{"a"});
  EXPECT_FALSE(none.has("ana", "a"));
  AnswerLedger ledger(1 << 20);
  EXPECT_TRUE(ledger.add("ana", "a", 1, 10).empty());
  EXPECT_TRUE(ledger.add("bob", "a", 1, 10).empty());
  EXPECT_TRUE(ledger.add("ana", "b", 10, 10).empty()) << "bob has the other one still";
  EXPECT_FALSE(ledger.has("ana", "a"));
  EXPECT_TRUE(ledger.has("bob", "a"));
  EXPECT_EQ(ledger.add("ana", "c", 11, 10), (std::vector<std::string>{"b", "c"}));
  EXPECT_EQ(ledger.bytes_of("ana"), 0u);
  EXPECT_EQ(ledger.held_bytes(), AnswerLedger::kBytesPerEntry);
}

TEST(Accounts, ANewFileKeepsWhatANameHasUsedAndForgetsWhoIsGone) {
  const auto file = [](const std::string& names, int rate) {
    std::string text;
    for (const char name : names)
      text += std::string(text.empty() ? "" : ",") + "{\"name\":\"" + name + "\",\"tokens\":[{\"sha256\":\"" +
              sha256(std::string_view(&name, 1)).hex() +
              "\"}],\"scopes\":[\"read\"],\"requests_per_second\":" + std::to_string(rate) + "}";
    return *TokenFile::parse("{\"tenants\":[" + text + "]}");
  };
  Accounts accounts(file("ab", 1));
  EXPECT_FALSE(accounts.open());
  const auto a = accounts.find("a").account;
  ASSERT_TRUE(a);
  EXPECT_FALSE(a->request(kStart));
  EXPECT_TRUE(a->request(kStart));
  accounts.replace(file("ac", 2));
  EXPECT_EQ(accounts.find("a").account, a);
  EXPECT_TRUE(a->request(kStart)) << "a reload is no pardon";
  EXPECT_FALSE(a->request(kStart + milliseconds(500))) << "the new rate";
  EXPECT_FALSE(accounts.find("b").account);
  EXPECT_TRUE(accounts.find("c").account);
  EXPECT_EQ(accounts.all().size(), 2u);
}

}  // namespace
}  // namespace fracture::tenants
