#include "cli/test_watch.h"

#include <chrono>
#include <thread>

#include "cli/stop.h"

namespace feder::cli {

TestWatch::Known TestWatch::look(const std::string& file) {
  std::error_code ignored;
  Known known;
  known.time = std::filesystem::last_write_time(file, ignored);
  known.size = std::filesystem::file_size(file, ignored);
  return known;
}

void TestWatch::set(const std::vector<std::string>& files) {
  std::map<std::string, Known> now;
  // a save between a test's reading and this call is not lost
  for (const std::string& file : files) now[file] = files_.contains(file) ? files_[file] : look(file);
  files_ = std::move(now);
}

std::set<std::string> TestWatch::wait() {
  constexpr auto kPoll = std::chrono::milliseconds(100);
  std::set<std::string> changed;
  while (!stop_flag()) {
    std::this_thread::sleep_for(kPoll);
    bool moving = false;
    for (auto& [file, known] : files_) {
      const Known now = look(file);
      if (now == known) continue;
      known = now, moving = true;
      changed.insert(file);
    }
    if (!changed.empty() && !moving) return changed;
  }
  return {};
}

}  // namespace feder::cli
