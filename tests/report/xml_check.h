// A small reader of XML: enough to say whether a drawing or page is well formed.
#pragma once
#include <string>
#include <vector>

namespace feder::test {

// "" when every tag closes in order, attributes are quoted and '&' begins an entity; otherwise what is wrong. Tags that
// HTML leaves open (meta, !DOCTYPE) are skipped; the text of <style> is not looked at.
inline std::string xml_fault(const std::string& text) {
  std::vector<std::string> open;
  for (std::size_t at = 0; at < text.size();) {
    if (!open.empty() && open.back() == "style") {
      at = text.find("</style>", at);
      if (at == std::string::npos) return "style is not closed";
    }
    const char c = text[at];
    if (c == '&') {
      const std::size_t end = text.find(';', at);
      if (end == std::string::npos || end - at > 8)
        return "bare & at " + std::to_string(at) + ": " + text.substr(at, 20);
      at = end + 1;
      continue;
    }
    if (c == '>') return "bare > at " + std::to_string(at) + ": " + text.substr(at > 20 ? at - 20 : 0, 30);
    if (c != '<') {
      ++at;
      continue;
    }
    std::size_t end = at + 1;
    for (bool quoted = false; end < text.size() && (quoted || text[end] != '>'); ++end) {
      if (text[end] == '"') quoted = !quoted;
      if (text[end] == '<') return "bare < at " + std::to_string(end) + ": " + text.substr(end, 20);
    }
    if (end >= text.size()) return "tag without end at " + std::to_string(at);
    const std::string tag = text.substr(at + 1, end - at - 1);
    at = end + 1;
    const std::string name = tag.substr(0, tag.find_first_of(" \n/", tag[0] == '/' ? 1 : 0));
    if (tag[0] == '?' || tag[0] == '!' || name == "meta") continue;
    if (tag[0] == '/') {
      if (open.empty() || "/" + open.back() != name)
        return "</" + name + " closes " + (open.empty() ? "nothing" : open.back());
      open.pop_back();
    } else if (tag.back() != '/') {
      open.push_back(name);
    }
  }
  return open.empty() ? "" : open.back() + " is not closed";
}

inline int count_of(const std::string& text, const std::string& part) {
  int n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++n;
  return n;
}

}  // namespace feder::test
