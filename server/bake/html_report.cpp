#include "server/bake/html_report.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "common/base/json_text.hpp"
#include "common/mesh/dropped.hpp"
#include "server/bake/output_path.hpp"
#include "server/bake/report.hpp"

namespace fracture::bake {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kGenerator = "<meta name=\"generator\" content=\"fracture-server bake\">";

constexpr const char* kStyle = R"(
:root { color-scheme: light dark; --back: #fff; --ink: #1c2127; --soft: #5b6570; --line: #dde2e7; --band: #f5f7f9;
  --bad: #b3261e; --warn: #8a5a00; }
@media (prefers-color-scheme: dark) {
  :root { --back: #14181d; --ink: #e6e9ed; --soft: #9aa5b1; --line: #2c343d; --band: #1b2127; --bad: #ff8a80; --warn: #f0b45b; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 80rem; padding: 1.5rem 1rem 4rem; background: var(--back); color: var(--ink);
  font: 15px/1.45 system-ui, sans-serif; }
h1 { font-size: 1.4rem; margin: 0 0 .2rem; overflow-wrap: anywhere; }
h2 { font-size: 1.1rem; margin: 2rem 0 .6rem; }
p { margin: .3rem 0; color: var(--soft); overflow-wrap: anywhere; }
a { color: inherit; }
dl { display: flex; flex-wrap: wrap; gap: .6rem 2rem; margin: 1rem 0; }
dt { color: var(--soft); font-size: .85rem; }
dd { margin: 0; font-size: 1.25rem; font-variant-numeric: tabular-nums; }
table { border-collapse: collapse; width: 100%; }
th { text-align: left; font-weight: 600; font-size: .85rem; color: var(--soft); }
th, td { padding: .5rem .75rem; border-bottom: 1px solid var(--line); vertical-align: top; }
tbody tr:nth-child(even) { background: var(--band); }
.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
.name, .why { overflow-wrap: anywhere; }
.name { min-width: 14rem; }
.name small { display: block; color: var(--soft); }
.pic { width: 9.5rem; }
.pic img { display: block; width: 8rem; height: 8rem; border-radius: 4px; background: var(--line); }
.bad { color: var(--bad); font-weight: 600; }
.warn { color: var(--warn); }
.notes { color: var(--soft); }
.notes summary { cursor: pointer; }
ul + .notes, .notes + .notes { margin-top: .3rem; }
ul { margin: 0; padding: 0; list-style: none; }
li + li { margin-top: .3rem; }
@media (max-width: 45rem) {
  thead { display: none; }
  table, tbody { display: block; }
  tr { display: grid; grid-template-columns: auto 1fr; gap: .1rem .9rem; padding: .8rem .5rem; border-bottom: 1px solid var(--line); }
  td { display: block; border: 0; padding: 0; grid-column: 2; }
  .name { min-width: 0; }
  td:empty { display: none; }
  .pic { grid-column: 1; grid-row: 1 / span 12; width: auto; }
  .pic img { width: 6rem; height: 6rem; }
  .pic:empty { display: none; }
  .pic:empty ~ td, .plain td { grid-column: 1 / -1; }
  .n { text-align: left; }
  td[data-of]::before { content: attr(data-of) " "; color: var(--soft); font-size: .85rem; }
})";

/// Escapes text for element content and double-quoted attributes. Control characters become spaces.
std::string as_html(std::string_view text) {
  std::string out;
  for (const char c : as_utf8(std::string(text))) switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
    }
  return out;
}

/// Isolates the text's direction with <bdi>: a right-to-left name cannot reorder the text around it.
std::string named(std::string_view text) { return "<bdi>" + as_html(text) + "</bdi>"; }

double number_in(const json& object, const char* name) {
  const auto at = object.find(name);
  return at != object.end() && at->is_number() ? at->get<double>() : 0;
}

/// Returns a relative link. All characters except the unreserved ones (RFC 3986) are percent-encoded, so that
/// no file name can start a scheme, a query or a fragment.
std::string link_to(const std::string& file, const std::string& page) {
  std::error_code error;
  const fs::path folder = fs::absolute(page, error).parent_path().lexically_normal();
  const std::string path = fs::absolute(file, error).lexically_normal().lexically_proximate(folder).string();
  std::string link;
  for (const char c : path) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       std::string_view("-._~/").find(c) != std::string_view::npos;
    char code[4];
    std::snprintf(code, sizeof code, "%%%02X", static_cast<unsigned char>(c));
    link += plain ? std::string(1, c) : code;
  }
  return link;
}

/// Returns "1 234 567", with thin spaces between groups of thousands.
std::string with_thin_spaces(std::uint64_t number) {
  std::string digits = std::to_string(number);
  for (std::size_t at = digits.size(); at > 3;) digits.insert(at -= 3, "\u202f");
  return digits;
}

std::string in_bytes(double bytes) {
  const char* units[] = {"B", "KiB", "MiB", "GiB", "TiB"};
  std::size_t unit = 0;
  for (; bytes >= 1024 && unit + 1 < std::size(units); ++unit) bytes /= 1024;
  char text[40];
  std::snprintf(text, sizeof text, unit == 0 || bytes >= 100 ? "%.0f %s" : "%.1f %s", bytes, units[unit]);
  return text;
}

std::string in_time(double seconds) {
  char text[60];
  const auto whole = static_cast<unsigned long long>(std::llround(seconds));
  if (seconds < 100)
    std::snprintf(text, sizeof text, "%.1f s", seconds);
  else if (whole < 3600)
    std::snprintf(text, sizeof text, "%llu min %llu s", whole / 60, whole % 60);
  else
    std::snprintf(text, sizeof text, "%llu h %llu min", whole / 3600, whole / 60 % 60);
  return text;
}

std::string milliseconds(double seconds) {
  const double ms = 1000 * seconds;
  char text[40];
  std::snprintf(text, sizeof text, "%.1f", ms);
  return ms < 10 ? text : with_thin_spaces(static_cast<std::uint64_t>(std::llround(ms)));
}

std::string figure(const std::string& what, const std::string& value, const char* kind = "") {
  return "<div><dt>" + what + "</dt><dd" + (*kind ? std::string(" class=\"") + kind + '"' : "") + ">" +
         value + "</dd></div>\n";
}

std::string name_cell(const json& line) {
  const std::string input = text_in(line, "input"), output = text_in(line, "output");
  return "<td class=\"name\">" + named(input == kStandardStream ? "standard input" : input) + "<small>" +
         named(output == kStandardStream ? "standard output" : output) + "</small></td>";
}

std::string not_made_row(const json& line) {
  const json none = json::object();
  const json& problem = line.contains("problem") ? line["problem"] : none;
  const std::string type = text_in(problem, "type"), title = text_in(problem, "title"),
                    parameter = text_in(problem, "parameter");
  std::string why = "<td class=\"why\">";
  if (!type.empty()) why += "<code>" + as_html(type.substr(type.rfind('/') + 1)) + "</code> ";
  if (!title.empty()) why += as_html(title) + ".<br>";
  why += as_html(text_in(problem, "detail"));
  if (!parameter.empty()) why += "<br>Parameter: <code>" + as_html(parameter) + "</code>";
  if (const auto errors = problem.find("errors"); errors != problem.end() && errors->is_array())
    for (std::size_t k = 1; k < errors->size(); ++k) why += "<br>" + as_html(text_in((*errors)[k], "detail"));
  return "<tr>" + name_cell(line) + "<td class=\"bad\">" + as_html(text_in(line, "status")) + "</td>" + why +
         "</td></tr>\n";
}

/// Returns each sentence of a list in the report line as an <li> element.
std::string items_of(const json& line, const char* list) {
  std::string items;
  if (const auto sentences = line.find(list); sentences != line.end() && sentences->is_array())
    for (const json& sentence : *sentences)
      if (sentence.is_string()) items += "<li>" + as_html(sentence.get_ref<const std::string&>()) + "</li>";
  return items;
}

std::string list_of(const std::string& items) { return items.empty() ? "" : "<ul>" + items + "</ul>"; }

/// Returns what the report line says was dropped as <li> elements.
std::string dropped_items(const json& line) {
  std::string items;
  if (const auto list = line.find("dropped"); list != line.end() && list->is_array())
    for (const json& entry : *list)
      items += "<li>" +
               as_html(to_text({text_in(entry, "what"), text_in(entry, "name"), text_in(entry, "reason")})) +
               "</li>";
  return items;
}

std::string collapsed(const char* title, const json& list, const std::string& items) {
  return "<details class=\"notes\"><summary>" + std::string(title) + ": " + with_thin_spaces(list.size()) +
         "</summary>" + list_of(items) + "</details>";
}

/// Returns the table cell with the warnings, and below them what was dropped and the notes in collapsed elements.
std::string remarks_cell(const json& line, const std::string& of_picture) {
  std::string warnings = items_of(line, "warnings");
  const std::string notes = items_of(line, "notes");
  if (!of_picture.empty()) warnings += "<li>No picture: " + as_html(of_picture) + "</li>";
  std::string cell = "<td class=\"why warn\">" + list_of(warnings);
  if (const std::string dropped = dropped_items(line); !dropped.empty())
    cell += collapsed("Dropped", line.at("dropped"), dropped);
  if (!notes.empty()) cell += collapsed("Notes", line.at("notes"), notes);
  return cell + "</td>";
}

std::string made_row(const json& line, const std::string& page, bool pictures) {
  std::string row = "<tr>", warning;
  if (pictures) {
    row += "<td class=\"pic\">";
    if (const auto preview = line.find("preview"); preview != line.end()) {
      warning = text_in(*preview, "warning");
      const std::string link = link_to(text_in(*preview, "file"), page);
      if (warning.empty())
        row += "<a href=\"" + link + "\"><img src=\"" + link + "\" alt=\"Fragments of " +
               as_html(text_in(line, "input")) +
               "\" width=\"128\" height=\"128\" loading=\"lazy\" decoding=\"async\"></a>";
    }
    row += "</td>";
  }
  const json none = json::object();
  const json& certificate = line.contains("certificate") ? line["certificate"] : none;
  return row + name_cell(line) + "<td class=\"n\" data-of=\"Fragments\">" +
         with_thin_spaces(static_cast<std::uint64_t>(number_in(certificate, "fragments"))) +
         "</td><td class=\"n\" data-of=\"ms\">" + milliseconds(number_in(line, "seconds")) +
         "</td><td class=\"n\" data-of=\"Size\">" + in_bytes(number_in(line, "bytes")) + "</td>" +
         remarks_cell(line, warning) + "</tr>\n";
}

/// Totals for the top of the page.
struct Totals {
  std::size_t refused = 0, failed = 0, warned = 0;
  std::uint64_t fragments = 0;
  double seconds = 0, bytes = 0;
};

}  // namespace

std::string html_report(const HtmlHead& head, const std::vector<json>& lines) {
  std::vector<const json*> made, not_made;
  Totals totals;
  bool pictures = false;
  for (const json& line : lines) {
    const std::string status = text_in(line, "status");
    if (status != "made") {
      not_made.push_back(&line);
      ++(status == "refused" ? totals.refused : totals.failed);
      continue;
    }
    made.push_back(&line);
    totals.seconds += number_in(line, "seconds");
    totals.bytes += number_in(line, "bytes");
    totals.fragments += static_cast<std::uint64_t>(number_in(line.at("certificate"), "fragments"));
    if (line.contains("warnings")) ++totals.warned;
    pictures = pictures || line.contains("preview");
  }
  std::stable_sort(made.begin(), made.end(), [](const json* a, const json* b) {
    return number_in(*a, "seconds") > number_in(*b, "seconds");
  });

  std::string page = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
  page += kGenerator;
  // Second line of defence: if a name is ever not escaped, the page still cannot run scripts or load
  // anything.
  page +=
      "\n<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src 'self' file:; style-src "
      "'unsafe-inline'; base-uri 'none'; form-action 'none'\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
      as_html(head.title) + "</title>\n<style>" + kStyle + "\n</style>\n</head>\n<body>\n<h1>" +
      named(head.title) + "</h1>\n";
  if (head.stopped)
    page += "<p class=\"bad\">Stopped: " + with_thin_spaces(head.jobs - std::min(head.jobs, lines.size())) +
            " jobs were not done. To continue, run the same command again.</p>\n";
  if (!head.no_pictures.empty()) page += "<p>No pictures were drawn: " + as_html(head.no_pictures) + "</p>\n";
  page +=
      "<dl>\n" + figure("Jobs", with_thin_spaces(head.jobs)) + figure("Made", with_thin_spaces(made.size()));
  if (head.kept > 0) page += figure("Kept from an earlier run", with_thin_spaces(head.kept));
  if (totals.refused > 0)
    page += figure("Refused", "<a href=\"#not-made\">" + with_thin_spaces(totals.refused) + "</a>", "bad");
  if (totals.failed > 0)
    page += figure("Failed", "<a href=\"#not-made\">" + with_thin_spaces(totals.failed) + "</a>", "bad");
  if (totals.warned > 0) page += figure("With warnings", with_thin_spaces(totals.warned), "warn");
  page += figure("Fragments", with_thin_spaces(totals.fragments)) +
          figure("Output size", in_bytes(totals.bytes)) + figure("Time of this run", in_time(head.seconds)) +
          figure("Total time of all meshes", in_time(totals.seconds)) + "</dl>\n";
  if (!not_made.empty()) {
    page +=
        "<h2 id=\"not-made\">Not made</h2>\n<table class=\"plain\">\n<thead><tr><th>Mesh</th><th></th><th>Why</th></tr></thead>\n<tbody>\n";
    for (const json* line : not_made) page += not_made_row(*line);
    page += "</tbody>\n</table>\n";
  }
  if (!made.empty()) {
    page += "<h2 id=\"made\">Made, slowest first</h2>\n<table>\n<thead><tr>";
    if (pictures) page += "<th></th>";
    page +=
        "<th>Mesh</th><th class=\"n\">Fragments</th><th class=\"n\">ms</th><th class=\"n\">Size</th>"
        "<th>Warnings, dropped items and notes</th></tr></thead>\n<tbody>\n";
    for (const json* line : made) page += made_row(*line, head.path, pictures);
    page += "</tbody>\n</table>\n";
  }
  return page + "</body>\n</html>\n";
}

bool may_be_html_report(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return true;
  char head[512] = {};
  file.read(head, sizeof head);
  return std::string_view(head, static_cast<std::size_t>(file.gcount())).find(kGenerator) !=
         std::string_view::npos;
}

}  // namespace fracture::bake
