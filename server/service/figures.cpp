#include "server/service/figures.hpp"

#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "common/base/error.hpp"

namespace fracture {
namespace {

using nlohmann::json;

/// A position in JSON text (RFC 8259) that can step over values without parsing them. If the text is not JSON, skimming
/// just ends early.
class Skim {
 public:
  Skim(std::string_view text, std::size_t at) : text_(text), at_(at) { space(); }

  std::size_t at() const { return at_; }
  bool take(char c) {
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    space();
    return true;
  }
  /// Steps over a string. Returns the characters between its quotes, with escapes left as they are.
  std::optional<std::string_view> string() {
    const std::size_t begin = at_;
    if (at_ >= text_.size() || text_[at_] != '"' || !pass_string(at_)) return std::nullopt;
    const std::string_view inside = text_.substr(begin + 1, at_ - begin - 2);
    space();
    return inside;
  }
  /// Steps over one value of any kind, and returns its range.
  std::optional<TextRange> value() {
    constexpr std::string_view kDelimiters = ",}] \t\r\n";
    const std::size_t begin = at_;
    std::size_t p = begin, depth = 0;
    do {
      if (p >= text_.size()) return std::nullopt;
      const char c = text_[p];
      if (c == '"') {
        if (!pass_string(p)) return std::nullopt;
        continue;
      }
      const bool opens = c == '{' || c == '[', closes = c == '}' || c == ']';
      if (closes && depth == 0) return std::nullopt;
      depth = opens ? depth + 1 : closes ? depth - 1 : depth;
      if (opens || closes || depth > 0)
        ++p;
      else
        p = std::min(text_.find_first_of(kDelimiters, p), text_.size());
    } while (depth > 0);
    if (p == begin) return std::nullopt;
    at_ = p;
    space();
    return TextRange{begin, p - begin};
  }

 private:
  /// Moves `p` from the opening quote to the character after the closing one.
  bool pass_string(std::size_t& p) const {
    for (++p; p < text_.size() && text_[p] != '"'; ++p)
      if (text_[p] == '\\') ++p;
    return p++ < text_.size();
  }
  void space() { at_ = std::min(text_.find_first_not_of(" \t\r\n", at_), text_.size()); }

  std::string_view text_;
  std::size_t at_;
};

/// Returns where the value of a member of the object at `at` begins. Looks only at the members before it.
std::optional<std::size_t> member(std::string_view text, std::size_t at, std::string_view name) {
  Skim skim(text, at);
  if (!skim.take('{')) return std::nullopt;
  while (const auto key = skim.string()) {
    if (!skim.take(':')) return std::nullopt;
    if (*key == name) return skim.at();
    if (!skim.value() || !skim.take(',')) return std::nullopt;
  }
  return std::nullopt;
}

std::string_view text_of(std::span<const std::uint8_t> file) {
  return {reinterpret_cast<const char*>(file.data()), file.size()};
}

/// Reads a certificate. Numbers that are missing become 0.
Certificate certificate_in(const json& c) {
  Certificate result;
  const auto read = [&](const char* name, auto& figure) { figure = c.value(name, figure); };
  read("open_edges", result.open_edges);
  read("volume_in", result.volume_in);
  read("volume_once", result.volume_once);
  read("volume_out", result.volume_out);
  read("volume_file", result.volume_file);
  read("relative_error", result.relative_error);
  read("pocket_volume", result.pocket_volume);
  read("pocket_area", result.pocket_area);
  read("unmirrored_caps", result.unmirrored_caps);
  read("area_in", result.area_in);
  read("area_out", result.area_out);
  read("sheet_area_in", result.sheet_area_in);
  read("sheet_area_out", result.sheet_area_out);
  read("sites_asked", result.sites_asked);
  read("cells", result.cells);
  read("islands", result.islands);
  read("united", result.united);
  read("dropped", result.dropped);
  read("fragments", result.fragments);
  read("crossing_caps", result.crossing_caps);
  return result;
}

}  // namespace

AnswerSummary summary_of(const FracturedSolid& fractured) {
  AnswerSummary summary{.certificate = fractured.set.certificate,
                        .partition = !fractured.report.barycenter,
                        .judged = true,
                        .remarks = {}};
  summary.remarks.add(fractured.report.remarks);
  summary.dropped = fractured.report.dropped;
  return summary;
}

std::optional<TextRange> figures_in(std::span<const std::uint8_t> file, OutputFormat format) {
  std::string_view text = text_of(file);
  std::size_t begin = 0;
  if (format == OutputFormat::kGlb) {
    // 12 bytes of header, then the JSON chunk as length, type, text (glTF 2.0, section 4.4).
    begin = 20;
    if (text.size() < begin) return std::nullopt;
    std::size_t length = 0;
    for (std::size_t k = 4; k-- > 0;) length = length << 8 | file[12 + k];
    if (length > text.size() - begin) return std::nullopt;
    text = text.substr(0, begin + length);
  }
  const auto nodes = member(text, begin, "nodes");
  if (!nodes) return std::nullopt;
  Skim skim(text, *nodes);
  if (!skim.take('[')) return std::nullopt;
  do {
    const auto extras = member(text, skim.at(), "extras");
    const auto figures = extras ? member(text, *extras, "fracture") : std::nullopt;
    // Fragments and clusters also have such objects, but without bonds.
    if (figures && member(text, *figures, "bonds")) return Skim(text, *figures).value();
  } while (skim.value() && skim.take(','));
  return std::nullopt;
}

AnswerSummary summary_in(std::span<const std::uint8_t> file, OutputFormat format) {
  const TextRange range = figures_in(file, format).value_or(TextRange());
  const std::string_view text = text_of(file).substr(range.at, range.size);
  const json figures = json_or_null(text, kOfAnAnswer);
  if (!figures.is_object()) throw InternalError("no node of the file has extras.fracture");
  const json certificate = figures.value("certificate", json());
  if (!certificate.is_object() || !certificate.contains("open_edges"))
    throw InternalError("the file has no certificate");
  const json report = figures.value("report", json::object());
  AnswerSummary summary{.certificate = certificate_in(certificate),
                        .partition = !report.contains("barycenter"),
                        .judged = certificate.contains("unmirrored_caps"),
                        .remarks = {}};
  for (const json& warning : report.value("warnings", json::array()))
    if (warning.is_string()) summary.remarks.warn(warning);
  for (const json& note : report.value("notes", json::array()))
    if (note.is_string()) summary.remarks.note(note);
  for (const json& entry : report.value("dropped", json::array())) {
    if (!entry.is_object()) continue;
    const auto field = [&entry](const char* key) {
      const auto at = entry.find(key);
      return at != entry.end() && at->is_string() ? at->get<std::string>() : std::string();
    };
    summary.dropped.push_back({field("what"), field("name"), field("reason")});
  }
  return summary;
}

}  // namespace fracture
