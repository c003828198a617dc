#include "view/file_watch.h"

#include <sys/inotify.h>
#include <unistd.h>

#include <chrono>
#include <fstream>

#include "base/hash.h"
#include "feder/snapshot.h"

namespace feder::view {
namespace {

namespace fs = std::filesystem;

// False when the file cannot be read now.
bool read_content(const fs::path& file, std::uint64_t& content) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return false;
  Hash h;
  char block[4096];
  while (in.read(block, sizeof block) || in.gcount() > 0)
    for (std::streamsize i = 0; i < in.gcount(); ++i) h.add(block[i]);
  content = h.value();
  return true;
}

}  // namespace

FileWatch::FileWatch(bool polling) {
  if (!polling) descriptor_ = inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
}

FileWatch::~FileWatch() {
  if (descriptor_ >= 0) close(descriptor_);
}

void FileWatch::set(const std::vector<fs::path>& files) {
  std::map<fs::path, Known> old;
  old.swap(files_);
  touched_ = old.empty() ? -1 : 0;
  for (const fs::path& file : files) {
    if (const auto known = old.find(file); known != old.end()) {
      files_.insert(*known);
      continue;
    }
    Known known;
    std::error_code ignored;
    read_content(file, known.content);
    known.time = fs::last_write_time(file, ignored);
    known.size = fs::file_size(file, ignored);
    files_[file] = known;
  }
  watch_folders();
}

void FileWatch::watch_folders() {
  if (descriptor_ < 0) return;
  std::map<fs::path, int> wanted;
  for (const auto& [file, known] : files_) {
    const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
    if (wanted.count(folder)) continue;
    if (auto old = folders_.extract(folder)) {
      wanted.insert(std::move(old));
      continue;
    }
    const int watch = inotify_add_watch(
        descriptor_, folder.c_str(), IN_MODIFY | IN_CLOSE_WRITE | IN_MOVED_TO | IN_MOVED_FROM | IN_CREATE | IN_DELETE);
    if (watch < 0) {
      // out of watches: polling serves as well
      close(descriptor_);
      descriptor_ = -1;
      folders_.clear();
      return;
    }
    wanted[folder] = watch;
  }
  for (const auto& [folder, watch] : folders_) inotify_rm_watch(descriptor_, watch);
  folders_ = std::move(wanted);
}

bool FileWatch::drain() {
  alignas(inotify_event) char buffer[16384];
  bool any = false;
  for (ssize_t size; (size = read(descriptor_, buffer, sizeof buffer)) > 0; any = true) {
    for (const char* at = buffer; at < buffer + size;) {
      const auto* event = reinterpret_cast<const inotify_event*>(at);
      at += sizeof(inotify_event) + event->len;
      if (event->len == 0) continue;
      const std::pair<int, std::string> file(event->wd, event->name);
      if (event->mask & (IN_MODIFY | IN_CREATE))
        open_.insert(file);
      else
        open_.erase(file);
    }
  }
  return any;
}

bool FileWatch::poll() {
  bool any = false;
  for (auto& [file, known] : files_) {
    std::error_code gone;
    const auto time = fs::last_write_time(file, gone);
    const auto size = fs::file_size(file, gone);
    if (gone || (time == known.time && size == known.size)) continue;
    known.time = time, known.size = size;
    any = true;
  }
  return any;
}

bool FileWatch::changed(double now) {
  bool touched = false;
  if (descriptor_ >= 0) {
    touched = drain();
  } else if (now - looked_ >= kPoll) {
    looked_ = now;
    touched = poll();
  }
  if (touched) touched_ = now;
  const bool complete = descriptor_ >= 0 && open_.empty();
  if (touched_ < 0 || (!complete && now - touched_ < kQuiet)) return false;
  touched_ = -1;
  open_.clear();
  bool any = false;
  for (auto& [file, known] : files_) {
    std::uint64_t content = 0;
    if (!read_content(file, content) || content == known.content) continue;
    known.content = content;
    std::error_code ignored;
    const auto age = fs::file_time_type::clock::now() - fs::last_write_time(file, ignored);
    age_ = std::chrono::duration<double>(age).count();
    any = true;
  }
  return any;
}

}  // namespace feder::view
