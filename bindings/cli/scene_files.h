// Scenes in folders.
#pragma once
#include <functional>
#include <string>
#include <vector>

namespace feder::cli {

// A Lua file that has this call ("feder.scene"), or a YAML file with objects; libraries and material tables are none.
bool looks_like_scene(const std::string& file, const char* call);

// The files as given, and those of folders that are wanted; sorted, each once. Failure (usage) for what does not exist.
std::vector<std::string> find_files(const std::vector<std::string>& paths,
                                    const std::function<bool(const std::string&)>& wanted);

}  // namespace feder::cli
