// Writes the report of a bake as an HTML page: one file without scripts that loads nothing from the network.
// Pictures are linked as files next to the page.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace fracture::bake {

struct HtmlHead {
  std::string title{};   ///< what was baked: "assets -> broken"
  std::size_t jobs = 0;  ///< in this run; more than the number of lines if the run was stopped
  std::size_t kept = 0;  ///< outputs kept from an earlier run
  double seconds = 0;    ///< duration of this run
  bool stopped = false;
  std::string no_pictures{};  ///< a sentence: why the page has no pictures; empty if it has
  std::string path{};         ///< of the page; links are relative to its folder
};

/// Returns the page for `lines`, the lines of the report (proto/bake/report.schema.json) in job order. Failed
/// jobs are listed first, then the outputs, slowest first. All text is escaped; invalid UTF-8 is
/// shown as U+FFFD.
std::string html_report(const HtmlHead& head, const std::vector<nlohmann::json>& lines);

/// Returns whether a report page may be written to `path`: there is no file yet, or it is a page that a bake
/// has written. Other files must not be overwritten.
bool may_be_html_report(const std::string& path);

}  // namespace fracture::bake
