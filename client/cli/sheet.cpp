#include "client/cli/sheet.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "client/render/text.hpp"

namespace fracture::cli {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxCells = 1024;

const json kNothing = json::object();

const json& member(const json& object, const char* key) {
  const auto it = object.find(key);
  return it == object.end() ? kNothing : *it;
}

/// "columns" or "rows": an array of objects with a label.
Expected<std::vector<json>> headings(const json& document, const char* key, const std::string& path) {
  const auto it = document.find(key);
  if (it == document.end()) return std::vector<json>{json::object()};
  if (!it->is_array() || it->empty())
    return fail(ErrorCode::kBadParameter, path + ": /" + key + " must be an array with at least one object.");
  for (std::size_t k = 0; k < it->size(); ++k)
    if (!(*it)[k].is_object() || ((*it)[k].contains("label") && !(*it)[k]["label"].is_string()))
      return fail(ErrorCode::kBadParameter,
                  path + ": /" + key + "/" + std::to_string(k) +
                      " must be an object, and its label, if any, must be a string.");
  return it->get<std::vector<json>>();
}

Expected<Sheet> parse(const json& document, const std::string& path) {
  if (!document.is_object()) return fail(ErrorCode::kBadParameter, path + " must contain a JSON object.");
  for (const auto& [key, value] : document.items())
    if (key != "title" && key != "options" && key != "columns" && key != "rows" && key != "cells")
      return fail(ErrorCode::kBadParameter,
                  path + ": there is no member '" + key + "'; known: title, options, columns, rows, cells.");
  Sheet sheet;
  if (const auto it = document.find("title"); it != document.end() && it->is_string()) sheet.title = *it;
  const auto columns = headings(document, "columns", path), rows = headings(document, "rows", path);
  if (!columns) return tl::unexpected(columns.error());
  if (!rows) return tl::unexpected(rows.error());
  if (rows->size() * columns->size() > kMaxCells)
    return fail(ErrorCode::kTooLarge, path + " has " + std::to_string(rows->size() * columns->size()) +
                                          " pictures; the maximum for a sheet is " +
                                          std::to_string(kMaxCells) + ".");
  for (const json& column : *columns) sheet.columns.push_back(column.value("label", ""));
  for (const json& row : *rows) sheet.rows.push_back(row.value("label", ""));

  PictureOptions base;
  if (const auto set = set_options(base, member(document, "options"), path + ": /options"); !set)
    return tl::unexpected(set.error());
  const json& cells = member(document, "cells");
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  for (std::size_t r = 0; r < rows->size(); ++r)
    for (std::size_t c = 0; c < columns->size(); ++c) {
      PictureOptions cell = base;
      const bool has_own = cells.is_array() && r < cells.size() && cells[r].is_array() && c < cells[r].size();
      const std::string at = std::to_string(r) + "/" + std::to_string(c);
      for (const auto& [where, options] :
           {std::pair<std::string, const json*>{"/rows/" + std::to_string(r), &member((*rows)[r], "options")},
            {"/columns/" + std::to_string(c), &member((*columns)[c], "options")},
            {"/cells/" + at, has_own ? &cells[r][c] : &kNothing}})
        if (const auto set = set_options(cell, *options, path + ": " + where); !set)
          return tl::unexpected(set.error());
      cell.width = base.width;
      cell.height = base.height;
      if (cell.file.empty())
        return fail(ErrorCode::kBadParameter, path + ": the cell " + at + " (row/column) has no file.");
      cell.file = (folder / cell.file).string();
      sheet.cells.push_back(std::move(cell));
    }
  return sheet;
}

}  // namespace

Expected<Sheet> read_sheet(const std::string& path) {
  std::error_code unknown;
  std::ifstream in(path, std::ios::binary);
  if (!in || std::filesystem::is_directory(path, unknown))
    return fail(ErrorCode::kFileAccess, "Cannot read " + path + ".");
  try {
    return parse(json::parse(in), path);
  } catch (const json::parse_error& error) {
    return fail(ErrorCode::kBadParameter,
                path + " is not valid JSON (error at byte " + std::to_string(error.byte) + ").");
  }
}

Expected<render::Picture> compose_sheet(
    const Sheet& sheet, const std::function<Expected<render::Picture>(const PictureOptions&)>& draw) {
  const int width = sheet.cells.front().width, height = sheet.cells.front().height;
  const auto columns = static_cast<int>(sheet.columns.size()), rows = static_cast<int>(sheet.rows.size());
  constexpr render::Color kPaper = {250, 250, 250, 255}, kInk = {30, 34, 40, 255};
  constexpr int kGap = 6;
  const float text = std::clamp(static_cast<float>(height) / 14.f, 13.f, 24.f);
  const auto labelled = [](const std::vector<std::string>& labels) {
    return std::any_of(labels.begin(), labels.end(), [](const std::string& label) { return !label.empty(); });
  };
  const bool any_text = !sheet.title.empty() || labelled(sheet.columns) || labelled(sheet.rows);
  std::optional<render::Font> font;
  if (any_text) {
    Expected<render::Font> opened = render::Font::open();
    if (!opened) return tl::unexpected(opened.error());
    font.emplace(std::move(*opened));
  }
  int left = kGap, top = kGap;
  for (const std::string& label : sheet.rows)
    if (!label.empty()) left = std::max(left, font->width(label, text) + 3 * kGap);
  const int title_height = sheet.title.empty() ? 0 : static_cast<int>(1.9f * text);
  const int label_height = labelled(sheet.columns) ? static_cast<int>(1.5f * text) : 0;
  top += title_height + label_height;
  const int whole_width = left + columns * (width + kGap), whole_height = top + rows * (height + kGap);
  if (whole_width > render::kMaxPictureSide || whole_height > render::kMaxPictureSide)
    return fail(ErrorCode::kTooLarge, "The sheet would have " + std::to_string(whole_width) + " x " +
                                          std::to_string(whole_height) + " pixels; a side can have at most " +
                                          std::to_string(render::kMaxPictureSide) +
                                          ". Use smaller pictures or fewer of them.");
  render::Picture page(whole_width, whole_height, kPaper);
  if (!sheet.title.empty())
    font->draw(page, kGap, static_cast<int>(1.35f * text), 1.25f * text, kInk, sheet.title);
  for (int c = 0; c < columns; ++c) {
    const std::string& label = sheet.columns[static_cast<std::size_t>(c)];
    if (label.empty()) continue;
    const int x = left + c * (width + kGap) + (width - font->width(label, text)) / 2;
    font->draw(page, x, top - static_cast<int>(0.5f * text), text, kInk, label);
  }
  for (int r = 0; r < rows; ++r) {
    const std::string& label = sheet.rows[static_cast<std::size_t>(r)];
    if (!label.empty())
      font->draw(page, kGap, top + r * (height + kGap) + height / 2 + static_cast<int>(text / 3), text, kInk,
                 label);
    for (int c = 0; c < columns; ++c) {
      const Expected<render::Picture> picture = draw(sheet.cells[static_cast<std::size_t>(r * columns + c)]);
      if (!picture) return tl::unexpected(picture.error());
      paste(page, *picture, left + c * (width + kGap), top + r * (height + kGap));
    }
  }
  return page;
}

}  // namespace fracture::cli
