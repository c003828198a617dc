// feder new: a first scene to change, and what the language servers of Lua and YAML need to complete and check it.
#include <filesystem>

#include "cli/doc_pages.h"
#include "report/json.h"
#include "report/output_file.h"

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

constexpr const char* kYamlTemplate = R"(# yaml-language-server: $schema={schema}
# {file}: run it with `feder run {file}`.
title: {title}
seconds: 4
world: {{ gravity: [0, -9.81, 0] }}
params:
  count: {{ value: 5, min: 1, max: 20, help: crates in the tower }}

bodies:
  - {{ name: floor, type: static, shape: plane }}
  - name: crate
    shape: {{ box: [1, 1, 1] }}
    position: [0, 1.1, 0]
    repeat: {{ count: $count, step: [0, 1.1, 0] }}

check: |
  expect(world:is_finite())
  expect(world:max_penetration() < 0.01, "crates sink into each other")
)";

class New final : public Command {
 public:
  void declare(Arguments& a) override {
    a.text("NAME", name_, "NAME.lua is written; or NAME as it is where it ends in .yaml");
    a.require("NAME");
  }

  bool runs_scenes() const override { return false; }

  int run(const Options& options) override {
    namespace fs = std::filesystem;
    const bool yaml = name_.ends_with(".yaml") || name_.ends_with(".yml");
    const std::string file = yaml || name_.ends_with(".lua") ? name_ : name_ + ".lua";
    const fs::path path(file);
    std::error_code ignored;
    if (fs::exists(path, ignored)) throw Failure(kFailed, file + ": is there already; nothing was written");
    std::string title = path.stem().string();
    for (char& c : title)
      if (c == '"' || c == '\\' || static_cast<unsigned char>(c) < 0x20) c = '_';
    std::vector<std::string> written = {file};
    try {
      const std::string schema = std::string(".feder/") + kYamlSchema;
      report::write_text(
          file, fmt::format(fmt::runtime(yaml ? kYamlTemplate : kTemplate), fmt::arg("file", path.filename().string()),
                            fmt::arg("title", yaml ? report::Json(title).dump() : title), fmt::arg("schema", schema)));
      if (yaml)
        write_schema(path.parent_path() / schema, options.build, written);
      else
        write_stubs(path.parent_path(), options.build, written);
    } catch (const std::runtime_error& e) {
      throw Failure(kFailed, e.what());
    }
    if (options.json)
      print_json({{"file", file}, {"files", written}});
    else if (!options.quiet)
      fmt::print("{}\n", fmt::join(written, "\n"));
    return kPass;
  }

 private:
  static void write_schema(const std::filesystem::path& file, const Build& build, std::vector<std::string>& written) {
    std::error_code told_by_the_file;
    std::filesystem::create_directories(file.parent_path(), told_by_the_file);
    report::write_text(file.string(), report::to_text(yaml_schema(all_pages(build))));
    written.push_back(file.string());
  }

  // Stubs of this version; the settings that lead to them where the folder has none.
  static void write_stubs(const std::filesystem::path& folder, const Build& build, std::vector<std::string>& written) {
    const std::string stubs = (folder / ".feder" / "feder.lua").string(), settings = (folder / ".luarc.json").string();
    std::error_code told_by_the_file;
    std::filesystem::create_directories(folder / ".feder", told_by_the_file);
    report::write_text(stubs, pages_luacats(all_pages(build)));
    written.push_back(stubs);
    if (std::filesystem::exists(settings)) return;
    const report::Json json = {{"runtime.version", "Lua 5.4"},
                               {"workspace.library", {".feder", library_roots().front().string()}},
                               {"workspace.checkThirdParty", false},
                               // what an event or world:find gives may be any kind of object
                               {"type.weakUnionCheck", true}};
    report::write_text(settings, report::to_text(json));
    written.push_back(settings);
  }

  std::string name_;
};

}  // namespace

Row cli_new() {
  return command_row<New>("new", "writes a scene to start from, and stubs or a schema for its language server");
}

}  // namespace feder::cli
