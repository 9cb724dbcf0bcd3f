// The report of a bake as a page to look at: one HTML file without scripts, which asks nobody for anything; pictures are
// links to the files that lie beside it.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace fracture::bake {

struct HtmlHead {
  std::string title{};   ///< what this was: "assets -> broken"
  std::size_t jobs = 0;  ///< of this run; more than there are lines where it was stopped
  std::size_t kept = 0;  ///< of those that are made: by an earlier run
  double seconds = 0;    ///< of this run
  bool stopped = false;
  std::string no_pictures{};  ///< why there are none, a sentence; empty: there are
  std::string path{};         ///< of the page: links are relative to its folder
};

/// `lines`: those of the report (proto/bake/report.schema.json), in the order of the jobs. What was not made comes first, then
/// what was, the slowest first. All text is escaped; bytes that are no UTF-8 show as U+FFFD.
std::string html_report(const HtmlHead& head, const std::vector<nlohmann::json>& lines);

/// Is there nothing yet, or a page that a bake has written? Anything else would be lost.
bool may_be_html_report(const std::string& path);

}  // namespace fracture::bake
