#include "server/cli/inspect_list.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <iterator>

#include "common/base/exit_codes.hpp"
#include "common/base/printable.hpp"
#include "common/base/words.hpp"
#include "server/bake/mesh_search.hpp"

namespace fracture::cli {
namespace {

using nlohmann::json;

/// Worst last.
constexpr std::array kCodes{kExitDone, kExitRepaired, kExitRefused, kExitInternal, kExitSystem};

/// Maximum number of files that a line of the summary names.
constexpr std::size_t kNamed = 3;

constexpr std::array kKinds{"unreadable", "refused", "repaired", "drops", "overlaps", "warns", "offers"};
enum Kind : std::size_t { kUnreadable, kRefused, kRepaired, kDrops, kOverlaps, kWarns, kOffers };

/// The repairs that the solid's report counts, in words.
constexpr std::array<std::pair<const char*, const char*>, 8> kRepairs{
    {{"open_edges", "open edges"},
     {"nonmanifold_edges", "non-manifold edges"},
     {"flipped", "triangles that faced inwards"},
     {"degenerate_dropped", "triangles with two equal corners"},
     {"duplicates_dropped", "duplicate triangles"},
     {"welded_tolerant", "vertices merged within the tolerance"},
     {"sheets", "sheets without volume"},
     {"sheets_thickened", "sheets that became slabs"}}};

std::string text_of(const json& report, const char* name) {
  const auto at = report.find(name);
  return at != report.end() && at->is_string() ? at->get<std::string>() : std::string();
}

std::uint64_t number_in(const json& report, const char* object, const char* name) {
  const auto at = report.find(object);
  return at != report.end() && at->is_object() ? at->value(name, std::uint64_t{0}) : 0;
}

std::size_t length_of(const json& report, const char* list) {
  const auto at = report.find(list);
  return at != report.end() && at->is_array() ? at->size() : 0;
}

std::string size_in_words(const json& report) {
  const auto at = report.find("size");
  if (at == report.end() || !at->is_array() || at->size() != 3) return "size unknown";
  std::string text;
  for (const json& side : *at) text += (text.empty() ? "" : " x ") + short_number(side.get<double>());
  return text + " m";
}

std::string problem_in_words(const json& report) {
  const std::string error = text_of(report, "error"), detail = text_of(report, "detail");
  return text_of(report, "verdict") + ": " + (error.empty() ? "" : error + ": ") + shortened(detail);
}

}  // namespace

std::vector<std::pair<std::string, std::size_t>> losses_in(const json& report) {
  std::vector<std::pair<std::string, std::size_t>> losses;
  const auto add = [&](const std::string& what, std::size_t count) {
    if (count == 0) return;
    const auto at =
        std::find_if(losses.begin(), losses.end(), [&](const auto& loss) { return loss.first == what; });
    if (at == losses.end())
      losses.emplace_back(what, count);
    else
      at->second += count;
  };
  if (const auto dropped = report.find("dropped"); dropped != report.end() && dropped->is_array())
    for (const json& entry : *dropped) add(text_of(entry, "what"), 1);
  add("thin piece without volume", static_cast<std::size_t>(number_in(report, "solid", "shells_dropped")));
  return losses;
}

std::string line_of(const json& report) {
  std::string line = text_of(report, "input") + ": ";
  const std::string verdict = text_of(report, "verdict");
  if (verdict == "refused" || verdict == "unreadable") return printable(line + problem_in_words(report));
  line += verdict + "; " + size_in_words(report) + "; " +
          counted(number_in(report, "solid", "parts"), "part", "parts");
  const std::uint64_t overlaps = number_in(report, "contacts", "overlapping");
  line += overlaps > 0 ? "; " + counted(overlaps, "overlap", "overlaps") : "; no overlaps";
  std::string losses;
  for (const auto& [what, count] : losses_in(report))
    losses += (losses.empty() ? "" : ", ") + what + " (" + grouped(count) + ")";
  line += "; drops " + (losses.empty() ? "nothing" : losses);
  if (const std::size_t warnings = length_of(report, "warnings"); warnings > 0)
    line += "; " + counted(warnings, "warning", "warnings");
  if (const std::size_t choices = length_of(report, "choices"); choices > 0)
    line += "; " + counted(choices, "choice", "choices");
  return printable(line);
}

void InspectSummary::cause(std::size_t kind, const std::string& name, const std::string& input) {
  std::vector<std::string>& inputs = causes_[{kind, name}];
  if (inputs.empty() || inputs.back() != input) inputs.push_back(input);
}

void InspectSummary::add(const json& report, int exit_code) {
  ++files_;
  const auto code = std::find(kCodes.begin(), kCodes.end(), exit_code);
  worst_ = std::max(
      worst_, code == kCodes.end() ? kCodes.size() - 1 : static_cast<std::size_t>(code - kCodes.begin()));
  const std::string verdict = text_of(report, "verdict"), input = text_of(report, "input");
  ++verdicts_[verdict];
  if (verdict == "unreadable") return cause(kUnreadable, text_of(report, "detail"), input);
  if (verdict == "refused") return cause(kRefused, text_of(report, "error"), input);
  for (const auto& [figure, words] : kRepairs)
    if (number_in(report, "solid", figure) > 0) cause(kRepaired, words, input);
  for (const auto& [what, count] : losses_in(report)) cause(kDrops, what, input);
  if (number_in(report, "contacts", "overlapping") > 0) cause(kOverlaps, "parts that overlap", input);
  if (length_of(report, "warnings") > 0) cause(kWarns, "warnings", input);
  if (const auto choices = report.find("choices"); choices != report.end() && choices->is_array())
    for (const json& choice : *choices) cause(kOffers, text_of(choice, "kind"), input);
}

void InspectSummary::add_dangling(const std::string& link) {
  add({{"input", link}, {"verdict", "unreadable"}, {"detail", bake::kDangling}}, kExitSystem);
}

std::vector<InspectSummary::Cause> InspectSummary::sorted() const {
  std::vector<std::pair<std::size_t, Cause>> causes;
  for (const auto& [key, inputs] : causes_)
    causes.push_back({key.first, {kKinds[key.first], key.second, inputs}});
  std::stable_sort(causes.begin(), causes.end(), [](const auto& a, const auto& b) {
    if (a.first != b.first) return a.first < b.first;
    return a.second.inputs.size() > b.second.inputs.size();
  });
  std::vector<Cause> result;
  for (auto& [kind, cause] : causes) result.push_back(std::move(cause));
  return result;
}

std::vector<std::string> InspectSummary::lines() const {
  std::string first = counted(files_, "file", "files") + ":";
  bool any = false;
  for (const char* verdict : {"closed", "repaired", "refused", "unreadable"}) {
    const auto at = verdicts_.find(verdict);
    if (at == verdicts_.end()) continue;
    first += (any ? ", " : " ") + grouped(at->second) + " " + verdict;
    any = true;
  }
  std::vector<std::string> lines{first};
  for (const Cause& cause : sorted()) {
    std::string line = "  " + cause.kind + ": " + cause.name + ": " + grouped(cause.inputs.size()) + " (";
    for (std::size_t k = 0; k < std::min(kNamed, cause.inputs.size()); ++k)
      line += (k > 0 ? ", " : "") + cause.inputs[k];
    if (cause.inputs.size() > kNamed) line += ", and " + grouped(cause.inputs.size() - kNamed) + " more";
    lines.push_back(printable(line + ")"));
  }
  return lines;
}

json InspectSummary::document() const {
  json causes = json::array();
  for (const Cause& cause : sorted())
    causes.push_back({{"kind", cause.kind},
                      {"cause", cause.name},
                      {"count", cause.inputs.size()},
                      {"inputs", cause.inputs}});
  json summary = {{"files", files_}, {"causes", std::move(causes)}};
  for (const char* verdict : {"closed", "repaired", "refused", "unreadable"}) {
    const auto at = verdicts_.find(verdict);
    summary[verdict] = at == verdicts_.end() ? std::size_t{0} : at->second;
  }
  return summary;
}

int InspectSummary::exit_code() const { return kCodes[worst_]; }

}  // namespace fracture::cli
