// The scenes beside a scene, for the picker.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace feder::view {

struct SceneEntry {
  std::filesystem::path file;
  std::string name;   // "rigid/tower"
  std::string title;  // as the file says; may be empty
};

// All scenes in the folder named "scenes" above `file`, or in its own folder when there is none. Ordered by name.
std::vector<SceneEntry> scenes_beside(const std::filesystem::path& file);
// Each word of `words` is somewhere in the name or title, upper and lower case alike.
bool matches(const SceneEntry& entry, const std::string& words);

}  // namespace feder::view
