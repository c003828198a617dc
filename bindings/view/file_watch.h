// Notices that files were saved. inotify on their folders, since editors save by renaming; where there is none, by
// looking at times and sizes. Either way it is the content that counts: touching a file changes nothing.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace feder::view {

class FileWatch {
 public:
  explicit FileWatch(bool polling = false);
  ~FileWatch();
  FileWatch(const FileWatch&) = delete;
  FileWatch& operator=(const FileWatch&) = delete;

  // Watches these files from now on. What new ones hold now counts as known; those watched before keep what is known of
  // them, so that a save between reading and this call is not lost.
  void set(const std::vector<std::filesystem::path>& files);
  // True once after the content of a file has changed and it has been closed, or left alone for kQuiet. A file that is
  // missing is waited for.
  bool changed(double now);            // s, of any steady clock
  double age() const { return age_; }  // s from the writing of the last change to changed() seeing it
  bool polling() const { return descriptor_ < 0; }

 private:
  static constexpr double kQuiet = 0.04;  // s without another write: a file that stays open is complete
  static constexpr double kPoll = 0.1;    // s between two polls of times and sizes

  struct Known {
    std::uint64_t content = 0;
    std::filesystem::file_time_type time;
    std::uintmax_t size = 0;
  };
  bool drain();  // inotify: was something written?
  bool poll();   // polling: is a time or size other than last time?
  void watch_folders();

  int descriptor_ = -1;
  std::map<std::filesystem::path, Known> files_;
  std::map<std::filesystem::path, int> folders_;
  std::set<std::pair<int, std::string>> open_;  // (watch, name) of files that are being written
  double age_ = 0;
  double touched_ = -1;  // last write that has not been polled
  double looked_ = -1;
};

}  // namespace feder::view
