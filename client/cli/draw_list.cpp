#include "client/cli/draw_list.hpp"

#include <istream>
#include <ostream>

namespace fracture::cli {
namespace {

using nlohmann::json;

/// File names may contain any bytes, but an answer must be valid text.
std::string dump(const json& answer) { return answer.dump(-1, ' ', false, json::error_handler_t::replace); }

struct Line {
  PictureOptions options;
  std::string output;
};

Expected<Line> parse(const std::string& text) {
  json given = json::parse(text, nullptr, false);
  if (!given.is_object()) return fail(ErrorCode::kBadJson, "Each line must be a JSON object.");
  const auto output = given.find("output");
  if (output == given.end() || !output->is_string() || output->get_ref<const std::string&>().empty())
    return fail(ErrorCode::kBadParameter, "The line has no 'output'. Specify the PNG to write.");
  Line line;
  line.output = output->get<std::string>();
  given.erase(output);
  if (const auto set = set_options(line.options, given, "The line"); !set) return tl::unexpected(set.error());
  if (line.options.file.empty())
    return fail(ErrorCode::kBadParameter, "The line has no 'file'. Specify the GLB to render.");
  return line;
}

}  // namespace

void draw_list(
    std::istream& in, std::ostream& out,
    const std::function<Expected<void>(const PictureOptions& options, const std::string& output)>& draw) {
  for (std::string text; std::getline(in, text);) {
    json answer{{"output", nullptr}};
    const Expected<Line> line = parse(text);
    if (line) answer["output"] = line->output;
    const Expected<void> drawn =
        line ? draw(line->options, line->output) : Expected<void>(tl::unexpected(line.error()));
    if (!drawn)
      answer["problem"] = {{"type", std::string("/problems/") + slug(drawn.error().code)},
                           {"detail", drawn.error().detail}};
    out << dump(answer) << std::endl;  // flushed, so that a waiting reader gets it now
  }
}

}  // namespace fracture::cli
