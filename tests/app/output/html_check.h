#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace pathfit::app {

/// Empty if every element of the page is closed in order, attributes are quoted, and text has no
/// stray < or bare &; otherwise the first fault. Knows what our own pages use: void elements,
/// self-closed SVG, style and script.
inline std::string HtmlFault(std::string_view html) {
  const auto near = [&](std::size_t at) { return " near: " + std::string(html.substr(at, 80)); };
  const auto is_void = [](std::string_view name) {
    return name == "meta" || name == "img" || name == "br";
  };
  std::vector<std::string_view> open;
  for (std::size_t at = 0; at < html.size();) {
    if (html[at] == '&') {
      const std::size_t end = html.find(';', at);
      if (end == std::string_view::npos || end - at > 8) return "bare &" + near(at);
      at = end + 1;
      continue;
    }
    if (html[at] == '>') return "stray >" + near(at);
    if (html[at] != '<') {
      ++at;
      continue;
    }
    if (html.substr(at).starts_with("<!DOCTYPE html>")) {
      at += 15;
      continue;
    }
    const bool closing = html[at + 1] == '/';
    std::size_t end = at + 1 + (closing ? 1 : 0);
    const std::size_t name_begin = end;
    while (end < html.size() && html[end] != '>' && html[end] != ' ' && html[end] != '/') ++end;
    const std::string_view name = html.substr(name_begin, end - name_begin);
    if (name.empty()) return "stray <" + near(at);
    bool quoted = false;
    while (end < html.size() && (quoted || html[end] != '>')) {
      if (html[end] == '"') quoted = !quoted;
      if (html[end] == '<') return "< in a tag" + near(at);
      if (!quoted && html[end] == '=' && html[end + 1] != '"') return "unquoted value" + near(at);
      ++end;
    }
    if (end >= html.size()) return "unfinished tag" + near(at);
    const bool self_closed = html[end - 1] == '/';
    if (closing) {
      if (open.empty() || open.back() != name) return "wrong closing tag" + near(at);
      open.pop_back();
    } else if (!self_closed && !is_void(name)) {
      open.push_back(name);
      if (name == "style" || name == "script") {
        const std::string close = "</" + std::string(name) + ">";
        end = html.find(close, end) - 1;
      }
    }
    at = end + 1;
  }
  return open.empty() ? "" : "not closed: " + std::string(open.back());
}

/// Number of times `what` occurs.
inline int Count(std::string_view text, std::string_view what) {
  int count = 0;
  for (std::size_t at = text.find(what); at != std::string_view::npos;
       at = text.find(what, at + what.size())) {
    ++count;
  }
  return count;
}

}  // namespace pathfit::app
