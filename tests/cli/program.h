// The feder program as a black box: run it in a folder of its own, look at its exit status, stdout and stderr.
#pragma once
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

namespace feder::test {

inline std::string read_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

inline bool says(const std::string& text, const std::string& what) { return text.find(what) != std::string::npos; }

struct Outcome {
  int status = -1;
  std::string out, err;
  nlohmann::json json() const { return nlohmann::json::parse(out); }
};

// A temporary folder that the program runs in; removed at the end.
class Program {
 public:
  Program() {
    std::string pattern = (std::filesystem::temp_directory_path() / "feder_cli_XXXXXX").string();
    if (!mkdtemp(pattern.data())) throw std::runtime_error("no temporary folder");
    folder_ = pattern;
  }
  ~Program() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  std::string read(const std::string& name) const { return read_file(folder_ / name); }
  const std::filesystem::path& folder() const { return folder_; }

  // `arguments` as in a shell; scenes of the checkout as $S/rigid/tower.lua.
  Outcome run(const std::string& arguments) const { return shell("'" FEDER_BINARY_DIR "/feder' " + arguments); }

  Outcome shell(const std::string& command) const {
    const std::string text = "cd '" + folder_.string() +
                             "' && export XDG_CACHE_HOME=\"$PWD/.cache\" S='" FEDER_SOURCE_DIR "/scenes'; " + command +
                             " >.out 2>.err </dev/null";
    const int status = std::system(text.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), read(".out"), read(".err")};
  }

 private:
  std::filesystem::path folder_;
};

inline int count_lines(const std::string& text) { return static_cast<int>(std::count(text.begin(), text.end(), '\n')); }

inline std::string last_line(const std::string& text) {
  std::istringstream in(text);
  std::string last;
  for (std::string line; std::getline(in, line);) last = line;
  return last;
}

// A scene whose build and check are given; a falling ball otherwise.
inline std::string scene(const std::string& build, const std::string& check = "expect(world:is_finite())") {
  return "local feder = require 'feder'\nreturn feder.scene {\n  title = 'Probe', seconds = 0.5,\n  build = "
         "function(world, scene)\n" +
         build + "\n  end,\n  check = function(world, scene, expect)\n" + check + "\n  end,\n}\n";
}
inline const char* const kBall =
    "scene.ball = world:body { name = 'ball', shape = feder.sphere(0.5), position = { 0, 3, 0 } }";

}  // namespace feder::test
