// A screen that nobody sees (Xvfb), the viewer on it, a mouse and a keyboard (xdotool).
#pragma once
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "live.h"

namespace feder::test {

inline bool has_program(const char* name) {
  return std::system(("command -v " + std::string(name) + " >/dev/null 2>&1").c_str()) == 0;
}

class Process {
 public:
  Process() = default;
  // Starts a program; what it prints goes to `log`. `pass`: a descriptor that it inherits.
  Process(const std::vector<std::string>& words, const std::string& log,
          const std::vector<std::string>& environment = {}) {
    id_ = fork();
    if (id_ != 0) return;
    for (const std::string& e : environment) putenv(strdup(e.c_str()));
    if (!freopen(log.c_str(), "w", stdout) || dup2(fileno(stdout), 2) < 0) _exit(126);
    std::vector<char*> argv;
    for (const std::string& w : words) argv.push_back(const_cast<char*>(w.c_str()));
    argv.push_back(nullptr);
    execvp(argv[0], argv.data());
    _exit(127);
  }
  ~Process() { stop(); }
  Process(Process&& other) noexcept : id_(other.id_) { other.id_ = -1; }
  Process& operator=(Process&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  bool running() {
    if (id_ <= 0) return false;
    if (waitpid(id_, nullptr, WNOHANG) == 0) return true;
    id_ = -1;
    return false;
  }
  void stop() {
    if (!running()) return;
    kill(id_, SIGTERM);
    waitpid(id_, nullptr, 0);
    id_ = -1;
  }

 private:
  pid_t id_ = -1;
};

class Screen {
 public:
  Screen() {
    int ends[2];
    if (pipe(ends) != 0) return;
    // a server that resets when its last client leaves may turn away the next one
    server_ = Process({"Xvfb", "-displayfd", std::to_string(ends[1]), "-screen", "0", "800x600x24", "-nolisten", "tcp",
                       "-noreset", "-fbdir", (folder_ / ".").string()},
                      folder_ / "xvfb.log");
    close(ends[1]);
    char text[32] = {};
    if (read(ends[0], text, sizeof text - 1) > 0) display_ = ":" + std::to_string(std::atoi(text));
    close(ends[0]);
  }
  const std::string& display() const { return display_; }

  // The viewer in a window of 800 x 600 at the corner of the screen.
  void view(const std::filesystem::path& scene, std::vector<std::string> more = {}) {
    std::vector<std::string> words = {FEDER_BINARY_DIR "/feder",
                                      "view",
                                      scene.string(),
                                      "--size",
                                      "800x600",
                                      "--no-panels",
                                      "--detail",
                                      "least",
                                      "--status",
                                      folder_ / "status.json"};
    words.insert(words.end(), more.begin(), more.end());
    std::filesystem::remove(folder_ / "status.json");
    viewer_ = Process(words, folder_ / "viewer.log", {"DISPLAY=" + display_});
  }
  bool viewer_runs() { return viewer_.running(); }
  std::string log() const {
    std::ifstream in(folder_ / "viewer.log");
    return {std::istreambuf_iterator<char>(in), {}};
  }

  nlohmann::json status() const {
    std::ifstream in(folder_ / "status.json");
    return nlohmann::json::parse(in, nullptr, false);
  }
  // Waits until the status says something; the last status either way.
  bool wait(const std::function<bool(const nlohmann::json&)>& is_so, double seconds = 60) {
    const double start = now();
    do {
      const nlohmann::json s = status();
      if (s.is_object() && is_so(s)) return true;
      usleep(20000);
    } while (now() - start < seconds && viewer_.running());
    return false;
  }
  void input(const std::string& command) const {
    const int failed = std::system(("DISPLAY=" + display_ + " xdotool " + command).c_str());
    CHECK(failed == 0);
  }

  // What the window shows now: rows of r, g, b. Empty when it cannot be had.
  struct Shot {
    int width = 0, height = 0;
    std::vector<unsigned char> rgb;
    const unsigned char* at(int x, int y) const {
      return &rgb[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x))];
    }
  };
  Shot shot() const {
    // the X server keeps its screen in a file of the form XWD: numbers of 4 bytes, high byte first, then the pixels
    std::ifstream in(folder_ / "Xvfb_screen0", std::ios::binary);
    const std::string data{std::istreambuf_iterator<char>(in), {}};
    const auto number = [&](std::size_t field) {
      std::uint32_t x = 0;
      for (std::size_t k = 0; k < 4; ++k) x = x << 8 | static_cast<unsigned char>(data[4 * field + k]);
      return static_cast<std::size_t>(x);
    };
    Shot s;
    if (data.size() < 100 || number(11) != 32) return s;
    const std::size_t start = number(0) + number(19) * 12, row = number(12);
    s.width = static_cast<int>(number(4)), s.height = static_cast<int>(number(5));
    if (data.size() < start + row * number(5)) return {};
    for (std::size_t y = 0; y < number(5); ++y)
      for (std::size_t x = 0; x < number(4); ++x)
        for (std::size_t k = 0; k < 3; ++k)
          s.rgb.push_back(static_cast<unsigned char>(data[start + y * row + 4 * x + (2 - k)]));
    return s;
  }
  // Waits until the picture is as wanted.
  bool wait_picture(const std::function<bool(const Shot&)>& is_so, double seconds = 30) const {
    const double start = now();
    do {
      if (is_so(shot())) return true;
      usleep(100000);
    } while (now() - start < seconds);
    return false;
  }

 private:
  SceneFolder folder_;
  Process server_, viewer_;
  std::string display_;
};

// Share of pixels that differ visibly.
inline double difference(const Screen::Shot& a, const Screen::Shot& b) {
  if (a.rgb.size() != b.rgb.size() || a.rgb.empty()) return 1;
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.rgb.size(); i += 3) {
    int most = 0;
    for (std::size_t k = 0; k < 3; ++k) most = std::max(most, std::abs(a.rgb[i + k] - b.rgb[i + k]));
    count += most > 24;
  }
  return static_cast<double>(count) / (static_cast<double>(a.rgb.size()) / 3);
}

// Pixels within `slack` of a colour.
inline int count_color(const Screen::Shot& s, int r, int g, int b, int slack) {
  int count = 0;
  for (std::size_t i = 0; i < s.rgb.size(); i += 3)
    count +=
        std::abs(s.rgb[i] - r) <= slack && std::abs(s.rgb[i + 1] - g) <= slack && std::abs(s.rgb[i + 2] - b) <= slack;
  return count;
}

}  // namespace feder::test
