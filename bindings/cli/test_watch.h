// Waits for files to be saved: feder test --watch.
#pragma once
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace feder::cli {

// Looks at times and sizes, since tests may be anywhere, on any file system.
class TestWatch {
 public:
  // What the files hold now counts as known.
  void set(const std::vector<std::string>& files);
  // Waits until some are other than known, and at rest for a moment. Empty when the command has to end.
  std::set<std::string> wait();

 private:
  struct Known {
    std::filesystem::file_time_type time = {};
    std::uintmax_t size = 0;
    bool operator==(const Known&) const = default;
  };
  static Known look(const std::string& file);
  std::map<std::string, Known> files_;
};

}  // namespace feder::cli
