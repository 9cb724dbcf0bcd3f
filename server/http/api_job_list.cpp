// GET /jobs: lists the client's jobs that it has not deleted, newest first, in pages.
#include <algorithm>
#include <charconv>

#include "common/base/printable.hpp"
#include "common/base/words.hpp"
#include "server/http/api.hpp"
#include "server/http/job_document.hpp"

namespace fracture::http {
namespace {

/// Pages longer than kUsualPage are written on the pool, because a hundred jobs take half a millisecond.
constexpr std::size_t kUsualPage = 20, kLongestPage = 100;
/// Estimated bytes per job in the list.
constexpr std::uint64_t kJobBytes = 512;

struct Page {
  Jobs::Filter filter;
  std::size_t limit = kUsualPage;
};

tl::unexpected<Problem> wrong(const std::string& name, std::string detail) {
  return tl::unexpected<Problem>(to_problem({ErrorCode::kBadParameter, std::move(detail), name}));
}

OrProblem<Page> page_of(const std::vector<std::pair<std::string, std::string>>& query) {
  Page page;
  for (std::size_t k = 0; k < query.size(); ++k) {
    const auto& [name, value] = query[k];
    const auto same = [&n = name](const auto& other) { return other.first == n; };
    if (std::any_of(query.begin(), query.begin() + static_cast<std::ptrdiff_t>(k), same))
      return wrong(name, "'" + name + "' is given twice. Give it once.");
    if (name == "state") {
      page.filter.state = job_state_named(value);
      if (!page.filter.state)
        return wrong(name, "'state' must be queued, running, done, failed or cancelled; it was '" +
                               shortened(printable(value)) + "'.");
    } else if (name == "limit") {
      const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), page.limit);
      if (error != std::errc{} || end != value.data() + value.size() || page.limit < 1 ||
          page.limit > kLongestPage)
        return wrong(name, "'limit' must be a whole number from 1 to " + grouped(kLongestPage) +
                               "; it was '" + shortened(printable(value)) + "'.");
    } else if (name == "before") {
      const auto time = time_in(value);
      if (!time) return wrong(name, "'before' must be the 'created' time of a job in this list.");
      page.filter.before = *time;
    } else {
      return tl::unexpected<Problem>(
          to_problem({ErrorCode::kUnknownParameter,
                      "'" + name.substr(0, 100) +
                          "' is not a parameter of this path; the parameters are state, limit and before.",
                      name.substr(0, 100)}));
    }
  }
  return page;
}

}  // namespace

Answered Api::get_jobs(const std::shared_ptr<Request>& request, const std::stop_token& gone,
                       const Reply& reply) {
  OrProblem<Page> page = page_of(request->admission.query);
  if (!page) return tl::unexpected<Problem>(std::move(page.error()));
  if (const auto& account = request->payer.account)
    page->filter.sees = [account](const std::string& owner) { return account->sees(owner); };
  const auto list = [this, request, page = *page] { return list_jobs(page.filter, page.limit, request->id); };
  if (page->limit <= kUsualPage) return list();
  OrProblem<Terms> terms = terms_of(*request, gone);
  if (!terms) return tl::unexpected<Problem>(std::move(terms.error()));
  terms->needs_seat = false;  // listing computes nothing
  return on_pool(expected_reading(kJobBytes * page->limit), request, *terms, reply,
                 [list](const Execution&) -> Answered { return list(); });
}

Response Api::list_jobs(const Jobs::Filter& filter, std::size_t limit, const std::string& request_id) {
  std::vector<JobView> jobs = jobs_.list(filter, limit + 1);
  const bool more = jobs.size() > limit;
  if (more) jobs.pop_back();

  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const JobView& job : jobs) list.push_back(describe(job, request_id));
  nlohmann::ordered_json document = {{"jobs", std::move(list)}};
  std::string next;
  if (more) {
    next = "/jobs?";
    if (filter.state) next += std::string("state=") + name_of(*filter.state) + "&";
    next += "limit=" + std::to_string(limit) + "&before=" + time_text(jobs.back().created);
    document["next"] = next;
  }
  Response response = Response::json(document);
  response.headers.emplace_back("Cache-Control", "no-store");
  if (more) response.headers.emplace_back("Link", "<" + next + ">; rel=\"next\"");
  return response;
}

}  // namespace fracture::http
