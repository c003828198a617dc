#include "view/scene_list.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <sstream>

namespace feder::view {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kFiles = 5000;  // looked at, before giving up on a folder that holds other things

std::string head_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string text(32768, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, in.gcount())));
  return text;
}

// What stands in quotes (or to the end of the line, in YAML) after `title`.
std::string title_in(const std::string& text) {
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    std::size_t at = line.find_first_not_of(" \t");
    if (at == std::string::npos || line.compare(at, 5, "title") != 0) continue;
    at = line.find_first_not_of(" \t=:", at + 5);
    if (at == std::string::npos) continue;
    const char quote = line[at];
    if (quote != '"' && quote != '\'') return line.substr(at);
    return line.substr(at + 1, line.find(quote, at + 1) - at - 1);
  }
  return "";
}

bool is_scene(const fs::path& file, const std::string& text) {
  if (file.extension() == ".lua") return text.find("feder.scene") != std::string::npos;
  return text.find("\nbodies:") != std::string::npos || text.find("\nnets:") != std::string::npos ||
         text.compare(0, 6, "title:") == 0 || text.find("\ntitle:") != std::string::npos;
}

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

}  // namespace

std::vector<SceneEntry> scenes_beside(const fs::path& file) {
  std::error_code error;
  const fs::path full = fs::absolute(file, error).lexically_normal();
  fs::path root = full.parent_path();
  for (fs::path up = root; up.has_relative_path(); up = up.parent_path())
    if (up.filename() == "scenes") root = up;
  std::vector<SceneEntry> list;
  std::size_t seen = 0;
  fs::recursive_directory_iterator walk(root, fs::directory_options::skip_permission_denied, error);
  for (; !error && walk != fs::recursive_directory_iterator() && seen < kFiles; walk.increment(error), ++seen) {
    const fs::path path = walk->path();
    const std::string name = path.filename().string();
    if (walk->is_directory(error) && (name.starts_with(".") || walk.depth() > 3)) walk.disable_recursion_pending();
    if (!walk->is_regular_file(error)) continue;
    if (path.extension() != ".lua" && path.extension() != ".yaml" && path.extension() != ".yml") continue;
    const std::string text = head_of(path);
    if (!is_scene(path, text)) continue;
    list.push_back({path, path.lexically_relative(root).replace_extension().generic_string(), title_in(text)});
  }
  std::sort(list.begin(), list.end(), [](const SceneEntry& a, const SceneEntry& b) { return a.file < b.file; });
  return list;
}

bool matches(const SceneEntry& entry, const std::string& words) {
  const std::string text = lower(entry.name + " " + entry.title);
  std::istringstream in(lower(words));
  for (std::string word; in >> word;)
    if (text.find(word) == std::string::npos) return false;
  return true;
}

}  // namespace feder::view
