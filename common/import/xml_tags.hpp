// Walks through the tags of XML without building a tree. For checks, and for formats that keep all their data in attributes.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace fracture::xml {

/// Returns the position after the tag that begins at `at`: after its '>' outside quotes.
inline std::size_t end_of_tag(std::string_view text, std::size_t at) {
  char quote = 0;
  for (; at < text.size(); ++at) {
    const char c = text[at];
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '>') {
      return at + 1;
    }
  }
  return at;
}

/// Calls f(tag with its brackets, its position) for every tag outside comments, CDATA and declarations. f
/// returns whether to continue.
template <class F>
void for_tags(std::string_view text, F&& f) {
  const auto skip_past = [&](std::size_t at, std::string_view end) {
    const std::size_t found = text.find(end, at);
    return found == std::string_view::npos ? text.size() : found + end.size();
  };
  for (std::size_t at = text.find('<'); at < text.size(); at = text.find('<', at)) {
    if (text.substr(at, 4) == "<!--") {
      at = skip_past(at, "-->");
    } else if (text.substr(at, 9) == "<![CDATA[") {
      at = skip_past(at, "]]>");
    } else if (text.substr(at, 2) == "<?" || text.substr(at, 2) == "<!") {
      at = skip_past(at, ">");
    } else {
      const std::size_t end = end_of_tag(text, at);
      if (!f(text.substr(at, end - at), at)) return;
      at = end;
    }
  }
}

/// Returns a name without its namespace prefix: "path" for "p:path".
inline std::string_view local_name(std::string_view name) {
  const std::size_t colon = name.rfind(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

/// Returns the local name of a tag: "object" for <m:object id="1"> and for </m:object>.
inline std::string_view name_of(std::string_view tag) {
  const std::size_t begin = tag.substr(0, 2) == "</" ? 2 : 1;
  if (tag.size() <= begin) return {};
  const std::size_t end = tag.find_first_of(" \t\r\n/>", begin);
  return local_name(tag.substr(begin, (end == std::string_view::npos ? tag.size() : end) - begin));
}

inline bool is_end(std::string_view tag) { return tag.substr(0, 2) == "</"; }
/// Whether the tag has no content: <object id="1"/>.
inline bool is_empty_element(std::string_view tag) { return tag.size() > 2 && tag[tag.size() - 2] == '/'; }

/// Calls f(name with its prefix, value as it is in the file) for every attribute.
template <class F>
void for_attributes(std::string_view tag, F&& f) {
  constexpr std::string_view kBlank = " \t\r\n";
  std::size_t at = tag.find_first_of(kBlank);
  while (at < tag.size()) {
    at = tag.find_first_not_of(kBlank, at);
    const std::size_t equals = at < tag.size() ? tag.find('=', at) : std::string_view::npos;
    const std::size_t open = equals < tag.size() ? tag.find_first_of("\"'", equals) : std::string_view::npos;
    const std::size_t close = open < tag.size() ? tag.find(tag[open], open + 1) : std::string_view::npos;
    if (close == std::string_view::npos) return;
    std::string_view name = tag.substr(at, equals - at);
    name = name.substr(0, name.find_first_of(kBlank));
    f(name, tag.substr(open + 1, close - open - 1));
    at = close + 1;
  }
}

/// Returns the value of the attribute with this local name, as it is in the file.
inline std::optional<std::string_view> attribute(std::string_view tag, std::string_view name) {
  std::optional<std::string_view> found;
  for_attributes(tag, [&](std::string_view each, std::string_view value) {
    if (!found && local_name(each) == name) found = value;
  });
  return found;
}

}  // namespace fracture::xml
