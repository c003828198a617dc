// A bar on stderr, redrawn ten times a second, only on a terminal.
#pragma once
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <string>

#include "feder/profile.h"

namespace feder::cli {

class Progress {
 public:
  explicit Progress(bool wanted) : on_(wanted && isatty(STDERR_FILENO) != 0) {}
  ~Progress() {
    if (drawn_) std::fputs("\r\033[K", stderr);
  }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // Is it time to draw again?
  bool due() const { return on_ && clock_nanoseconds() - last_ >= 100000000; }
  // `done` from 0 to 1; `words` behind the bar.
  void show(double done, const std::string& words) {
    last_ = clock_nanoseconds();
    drawn_ = true;
    constexpr int kWidth = 40;
    const int full = std::clamp(static_cast<int>(kWidth * done), 0, kWidth);
    fmt::print(stderr, "\r[{:<{}}] {}\033[K", std::string(static_cast<std::size_t>(full), '#'), kWidth, words);
    std::fflush(stderr);
  }

 private:
  bool on_, drawn_ = false;
  std::uint64_t last_ = clock_nanoseconds();
};

}  // namespace feder::cli
