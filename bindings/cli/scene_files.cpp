#include "cli/scene_files.h"

#include <algorithm>
#include <filesystem>

#include "cli/command.h"
#include "cli/session.h"

namespace feder::cli {

namespace fs = std::filesystem;

bool looks_like_scene(const std::string& file, const char* call) {
  if (file.ends_with(".lua")) return read_text(file).find(call) != std::string::npos;
  if (!is_yaml(file)) return false;
  const std::string text = "\n" + read_text(file);
  for (const char* key : {"\nbodies:", "\nnets:", "\ncloths:", "\nfluids:"})
    if (text.find(key) != std::string::npos) return true;
  return false;
}

std::vector<std::string> find_files(const std::vector<std::string>& paths,
                                    const std::function<bool(const std::string&)>& wanted) {
  std::vector<std::string> files;
  for (const std::string& path : paths) {
    std::error_code ignored;
    if (!fs::exists(path, ignored)) throw Failure(kUsage, path + ": no such file or folder");
    if (!fs::is_directory(path, ignored)) {
      files.push_back(path);
      continue;
    }
    for (const auto& entry : fs::recursive_directory_iterator(path))
      if (entry.is_regular_file() && wanted(entry.path().string())) files.push_back(entry.path().string());
  }
  std::ranges::sort(files);
  files.erase(std::unique(files.begin(), files.end()), files.end());
  return files;
}

}  // namespace feder::cli
