#include "server/http/job_document.hpp"

#include <charconv>
#include <cstdio>

#include "server/http/api.hpp"

namespace fracture::http {

using std::chrono::microseconds;

nlohmann::ordered_json describe(const JobView& job, std::string_view request_id) {
  nlohmann::ordered_json document = {
      {"id", job.id},           {"state", name_of(job.state)},       {"stage", job.stage},
      {"percent", job.percent}, {"created", time_text(job.created)}, {"durable", job.durable}};
  if (job.finished_at) document["finished"] = time_text(*job.finished_at);
  if (job.queue_position) document["queue_position"] = *job.queue_position;
  if (job.state == JobState::kDone) document["result"] = "/fractures/sha256:" + job.result_key;
  if (job.error) document["error"] = to_problem(*job.error).document(request_id);
  document["links"] = {{"self", "/jobs/" + job.id}, {"events", "/jobs/" + job.id + "/events"}};
  return document;
}

std::string time_text(std::chrono::sys_time<microseconds> time) {
  const auto day = std::chrono::floor<std::chrono::days>(time);
  const std::chrono::year_month_day date(day);
  const std::chrono::hh_mm_ss clock(time - day);
  char text[64];
  std::snprintf(text, sizeof text, "%04d-%02u-%02uT%02d:%02d:%02d.%06lldZ", static_cast<int>(date.year()),
                static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                static_cast<int>(clock.hours().count()), static_cast<int>(clock.minutes().count()),
                static_cast<int>(clock.seconds().count()),
                static_cast<long long>(clock.subseconds().count()));
  return text;
}

std::optional<std::chrono::sys_time<microseconds>> time_in(std::string_view text) {
  constexpr std::string_view kForm = "0000-00-00T00:00:00.000000Z";
  if (text.size() != kForm.size()) return std::nullopt;
  for (std::size_t i = 0; i < kForm.size(); ++i)
    if (kForm[i] == '0' ? text[i] < '0' || text[i] > '9' : text[i] != kForm[i]) return std::nullopt;
  const auto number = [&](std::size_t at, std::size_t size) {
    int value = 0;
    std::from_chars(text.data() + at, text.data() + at + size, value);
    return value;
  };
  const std::chrono::year_month_day date(std::chrono::year(number(0, 4)),
                                         std::chrono::month(static_cast<unsigned>(number(5, 2))),
                                         std::chrono::day(static_cast<unsigned>(number(8, 2))));
  if (!date.ok()) return std::nullopt;
  return std::chrono::sys_days(date) + std::chrono::hours(number(11, 2)) +
         std::chrono::minutes(number(14, 2)) + std::chrono::seconds(number(17, 2)) +
         microseconds(number(20, 6));
}

}  // namespace fracture::http
