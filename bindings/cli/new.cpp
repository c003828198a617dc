// feder new: a first scene to change.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "cli/command.h"
#include "report/json.h"

namespace feder::cli {
namespace {

constexpr const char* kTemplate = R"(-- {file}: run it with `feder run {file}`.
local feder = require "feder"

local count = feder.param("count", 5, {{ min = 1, max = 20, help = "crates in the tower" }})

return feder.scene {{
  title   = "{title}",
  seconds = 4,
  world   = {{ gravity = {{ 0, -9.81, 0 }} }},

  build = function(world, scene)
    world:body {{ name = "floor", type = "static", shape = feder.plane() }}
    for i = 1, count do
      scene.top = world:body {{ name = "crate" .. i, shape = feder.box(1, 1, 1), position = {{ 0, 1.1 * i, 0 }} }}
    end
    world:on("hit", {{ min_speed = 1 }}, function(e)
      print(("%s hits %s at %.1f m/s"):format(e.b:name(), e.a:name(), e.speed))
    end)
  end,

  check = function(world, scene, expect)
    local x, y, z = scene.top:position()
    expect(world:is_finite())
    expect(math.abs(y - (count - 0.5)) < 0.05, "the tower fell")
  end,
}}
)";

class New final : public Command {
 public:
  void declare(Arguments& a) override {
    a.text("NAME", name_, "NAME.lua is written");
    a.require("NAME");
  }

  bool runs_scenes() const override { return false; }

  int run(const Options& options) override {
    namespace fs = std::filesystem;
    const std::string file = name_.ends_with(".lua") ? name_ : name_ + ".lua";
    const fs::path path(file);
    std::error_code ignored;
    if (fs::exists(path, ignored)) throw Failure(kFailed, file + ": is there already; nothing was written");
    std::string title = path.stem().string();
    for (char& c : title)
      if (c == '"' || c == '\\' || static_cast<unsigned char>(c) < 0x20) c = '_';
    std::ofstream out(path, std::ios::binary);
    out << fmt::format(kTemplate, fmt::arg("file", path.filename().string()), fmt::arg("title", title));
    if (!out.flush()) throw Failure(kFailed, file + ": cannot be written");
    if (options.json) {
      print_json({{"file", file}});
    } else if (!options.quiet) {
      fmt::print("{}\n", file);
    }
    return kPass;
  }

 private:
  std::string name_;
};

}  // namespace

Row cli_new() { return command_row<New>("new", "writes a scene to start from"); }

}  // namespace feder::cli
