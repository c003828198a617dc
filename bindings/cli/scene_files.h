// Scenes in folders.
#pragma once
#include <string>
#include <vector>

namespace feder::cli {

// The files as given, and the .lua and .yaml files of folders that look like scenes; sorted, each once. Failure (usage)
// for what does not exist.
std::vector<std::string> scene_files(const std::vector<std::string>& paths);

}  // namespace feder::cli
