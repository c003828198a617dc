// What --json prints against the schemas that feder doc --schemas writes: every output is as its schema says, every row
// of bindings/cli/outputs.txt is met, and a field without a row is an error.
#include <map>
#include <regex>
#include <set>

#include "cli/program.h"
#include "support/catch.h"

using namespace feder::test;
using Json = nlohmann::json;

namespace {

// The part of JSON Schema that the program writes: type, pattern, properties, required, items, additionalProperties.
class Validator {
 public:
  void check(const Json& value, const Json& schema, const std::string& path) {
    seen.insert(path);
    if (!has_type(value, schema.at("type"))) return refuse(path, std::string("is of type ") + value.type_name());
    if (value.is_string() && schema.contains("pattern") &&
        !std::regex_search(value.get<std::string>(), std::regex(schema["pattern"].get<std::string>())))
      refuse(path, "is " + value.dump());
    if (value.is_array())
      for (const Json& item : value) check(item, schema.at("items"), path + "[]");
    if (value.is_object()) check_fields(value, schema, path);
  }

  std::set<std::string> seen;  // paths, as in outputs.txt
  std::vector<std::string> errors;

 private:
  void refuse(const std::string& path, const std::string& what) { errors.push_back(path + " " + what); }

  static bool has_type(const Json& value, const Json& types) {
    if (types.is_array()) return std::ranges::any_of(types, [&](const Json& t) { return has_type(value, t); });
    const std::string type = types, name = value.type_name();
    return type == "integer" ? value.is_number_integer() : type == name;
  }

  void check_fields(const Json& value, const Json& schema, const std::string& path) {
    const Json& more = schema.at("additionalProperties");
    const Json known = schema.value("properties", Json::object());
    for (const Json& name : schema.value("required", Json::array()))
      if (!value.contains(name.get<std::string>())) refuse(path, "lacks " + name.get<std::string>());
    for (const auto& [name, field] : value.items()) {
      if (known.contains(name))
        check(field, known[name], path + "." + name);
      else if (more.is_object())
        check(field, more, path + ".*");
      else
        refuse(path, "has a field without a row: " + name);
    }
  }
};

std::map<std::string, Json> schemas() {
  const Program p;
  std::map<std::string, Json> out;
  const Outcome written = p.run("doc --schemas s --json");
  REQUIRE(written.status == 0);
  const Json files = written.json()["files"];
  for (const Json& file : files) {
    const std::string name = std::filesystem::path(file.get<std::string>()).filename();
    if (name == "scene.yaml.schema.json") continue;  // of scenes, see test_yaml_schema.cpp
    out[name.substr(0, name.find('.'))] = Json::parse(p.read(file));
  }
  return out;
}

struct Row {
  std::string path, type, unit, text;
};
std::vector<Row> rows() {
  std::vector<Row> out;
  std::istringstream lines(read_file(FEDER_SOURCE_DIR "/bindings/cli/outputs.txt"));
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] == '#') continue;
    Row row;
    std::istringstream words(line);
    words >> row.path >> row.type >> row.unit >> std::ws;
    std::getline(words, row.text);
    out.push_back(row);
  }
  return out;
}

// An output and a command that prints it, F is the program; I: interrupted, once it has something to say. --json is
// added unless a # is at the end.
struct Sample {
  const char *output, *command;
};
constexpr Sample kSamples[] = {
    {"run", "F run $S/rigid/tower.lua --seconds 0.1 --check"},
    {"run", "F run $S/springs/hanging_net.lua --seconds 0.1"},
    {"run", "F run $S/cloth/flag.lua --seconds 0.1"},
    {"run", "F run $S/fluid/droplet_2d.lua --seconds 0.1"},
    {"run", "F run warns.lua --check"},
    {"run", "F run plain.lua"},
    {"run", "I F run $S/rigid/tower.lua --seconds 1e6"},
    {"replay", "F run warns.lua --record a.rec --quiet >/dev/null; F replay a.rec"},
    {"replay", "F run $S/rigid/tower.lua --record b.rec --seconds 0.1 --quiet >/dev/null; F replay b.rec"},
    {"replay_facts", "F replay a.rec --facts"},
    {"replay_facts", "F replay b.rec --facts"},
    {"diff", "F diff a.rec b.rec"},
    {"diff",
     "F run $S/rigid/tower.lua --record c.rec --set height=3 --seconds 0.1 --quiet >/dev/null; F diff b.rec c.rec"},
    {"explain", "F explain $S/rigid/tower.lua"},
    {"explain", "F explain $S/springs/hanging_net.lua"},
    {"explain", "F explain $S/mixed/everything.lua"},
    {"bench", "F bench $S/rigid/tower.lua --runs 2 --steps 5 --json > before.json; cat before.json #"},
    {"bench", "F bench $S/rigid/tower.lua --runs 1 --steps 5 --compare before.json"},
    {"bench", "I F bench $S/rigid/tower.lua --runs 10000 --steps 50"},
    {"bench_scenes", "F bench $S/rigid/tower.lua $S/cloth/flag.lua --runs 1 --steps 2"},
    {"bench_scenes", "F bench $S/rigid/tower.lua $S/fluid/droplet_2d.lua --runs 1 --steps 2 --compare before.json"},
    {"test", "F test draws.lua 'draws.lua[x=2]' skipped.lua --random 9"},
    {"test", "F test warns.lua broken_test.lua"},
    {"test_golden", "env -u CI F test golden.lua --update-golden >golden.log; cat golden.golden.json #"},
    {"test_golden", "env -u CI F test cloth.lua --update-golden >golden.log; cat cloth.golden.json #"},
    {"test_counterexamples", "env -u CI F test draws.lua --random 9 >t.log; cat draws.counterexamples.json #"},
    {"test_counterexamples", "env -u CI F test draws.lua --random 9 --seed 3 >t.log; cat draws.counterexamples.json #"},
    {"test_list", "F test --list $S/cloth"},
    {"test_list", "F test --list 'draws.lua[x=2]' $S/rigid/tower.lua"},
    {"check", "F check $S/rigid/tower.lua"},
    {"check", "F check misspelt.lua broken_test.lua"},
    {"new", "F new first"},
    {"new", "F new second.lua"},
    {"scenes", "F scenes"},
    {"scenes", "F scenes cloth"},
    {"doc", "F doc"},
    {"doc", "F doc hit"},
    {"doc_html", "F doc --html here"},
    {"doc_html", "F doc --html there/it/is"},
    {"doc_schemas", "F doc --schemas here"},
    {"doc_schemas", "F doc --schemas there/they/are"},
    {"render", "F render draws.lua -o still.png --size 64x48 --at 0"},
    {"render", "F render draws.lua skipped.lua -o sheet.png --size 64x48"},
    {"export", "F export draws.lua -o run.glb --seconds 0.1"},
    {"export", "F export draws.lua -o still.obj"},
    {"study",
     "F study oscillator --methods explicit_euler,rk45 --ladder steps:5..80:x2 --ladder tol:1e-2..1e-6:x10 "
     "--repeat 1 --set stiffness=1000 --out study"},
    {"study", "cat study/report.json #"},
    {"study_jsonl_first", "head -n 1 study/points.jsonl #"},
    {"study_jsonl", "sed -n 2p study/points.jsonl #"},
    {"study_jsonl", "tail -n 1 study/points.jsonl #"},
    {"study", "F study stack --ladder substeps:1,4 --repeat 0"},
    {"study", "F study oscillator --methods rk4 --ladder steps:80 --repeat 0 --baseline study/points.csv"},
    {"study", "I F study oscillator"},
    {"study_list", "F study --list"},
    {"study_list", "F study --list --quiet"},
    {"study_suite", "I F study --suite core --repeat 0"},
    {"study_suite", "F study --suite core --repeat 0 --baseline study/points.csv"},
    {"stability", "F stability --methods symplectic_euler,rk4 --x 0.1,1,3 --y 0,0.1 --bisect --out map"},
    {"stability", "cat map/stability.json #"},
    {"stability", "F stability stack --x 1,4"},
    {"stability", "I F stability"},
    {"stability_suite", "F stability --suite core --x 1 --y 1 --methods all"},
    {"stability_suite", "I F stability --suite core"},
    {"stability_list", "F stability --list"},
    {"stability_list", "F stability --list --quiet"},
    {"stability_extreme", "I F stability --suite extreme --out extreme"},
    {"stability_extreme", "I F stability --suite extreme"},
    {"stability", "cat extreme/stability.json #"},
};

void write_scripts(const Program& p) {
  const std::string cloth =
      "scene.cloth = world:cloth { size = { 1, 1 }, resolution = { 33, 33 }, pins = { 1, 33 }, solver = 'xpbd', "
      "stretch = 1e9, max_substeps = 1 }\n";
  p.write("warns.lua", scene(cloth + "world:on('step', function() error('no') end)",
                             "expect(false, 'never')\nexpect.near(1, 2, 0.1)"));
  p.write("draws.lua", "local x = require('feder').param('x', 1, { min = 0, max = 10 })\n" +
                           scene(kBall, "expect.budget { ms = 1e-9 }\nexpect(x < 5, 'x')"));
  const auto golden = [](const std::string& build) {
    return "local feder = require 'feder'\nreturn feder.scene { golden = true, seconds = 0.3, check = function() end, "
           "build = function(world, scene)\n" +
           build + "\nend }\n";
  };
  p.write("golden.lua", golden(kBall)), p.write("cloth.lua", golden(cloth));
  p.write("skipped.lua",
          "local feder = require 'feder'\nreturn feder.scene { title = 'No check', seconds = 0.1, "
          "build = function() end }\n");
  p.write("plain.lua", "local world = require('feder').world {}\nworld:step(3)\n");
  p.write("misspelt.lua", "local feder = require 'feder'\nlocal world = feder.wrld {}\n");
  p.write("broken_test.lua", "error('broken')\n");
}

std::string with_program(std::string command) {
  const std::string program = "'" FEDER_BINARY_DIR "/feder' ";
  const bool interrupted = command.starts_with("I ");
  if (interrupted) command.erase(0, 2);
  for (std::size_t at = 0; (at = command.find("F ", at)) != std::string::npos; at += program.size())
    command.replace(at, 2, program);
  if (command.back() != '#') command += " --json";
  if (!interrupted) return command;
  return "for t in 1 2 4 8 16; do timeout --foreground -s INT $t " + command +
         " > o.json; test $(wc -c < o.json) -gt 60 && break; done; cat o.json";
}

// All outputs of the samples, run once.
const std::vector<std::pair<std::string, Json>>& outputs() {
  static const auto all = [] {
    const Program p;
    write_scripts(p);
    std::vector<std::pair<std::string, Json>> out;
    for (const Sample& sample : kSamples) {
      const Outcome o = p.shell("{ " + with_program(sample.command) + "\n}");
      INFO(sample.command << "\n" << o.err);
      Json value = Json::parse(o.out, nullptr, false);  // one value and nothing else
      REQUIRE_FALSE(value.is_discarded());
      out.emplace_back(sample.output, std::move(value));
    }
    return out;
  }();
  return all;
}

// Objects within a value, as pointers from its root.
void find_objects(const Json& value, const Json::json_pointer& at, std::vector<Json::json_pointer>& out) {
  if (value.is_object()) {
    out.push_back(at);
    for (const auto& [name, field] : value.items()) find_objects(field, at / name, out);
  }
  if (value.is_array() && !value.empty()) find_objects(value[0], at / 0, out);
}

}  // namespace

TEST_CASE("every output of --json is as its schema says, and every field of the table is met", "[cli][schemas]") {
  const std::map<std::string, Json> all = schemas();
  Validator validator;
  std::map<std::string, int> count;
  for (const auto& [name, value] : outputs()) {
    CAPTURE(name);
    REQUIRE(all.count(name));
    ++count[name];
    validator.errors.clear();
    validator.check(value, all.at(name), name);
    CHECK(validator.errors == std::vector<std::string>{});
  }
  for (const auto& [name, schema] : all)
    // a window, which tests/view has; a line that there is once
    if (!name.starts_with("view") && name != "study_jsonl_first") CHECK(count[name] >= 2);
  for (const Row& row : rows()) {
    CAPTURE(row.path);
    if (!row.path.starts_with("view") && row.path.find(".csv.") == std::string::npos)
      CHECK(validator.seen.count(row.path));
  }
}

TEST_CASE("what a schema does not know, lacks or has otherwise is an error", "[cli][schemas]") {
  const std::map<std::string, Json> all = schemas();
  const auto errors = [&](const std::string& name, const Json& value) {
    Validator v;
    v.check(value, all.at(name), name);
    return v.errors.size();
  };
  std::set<std::string> tried;
  for (const auto& [name, value] : outputs()) {
    if (!tried.insert(name).second) continue;
    CAPTURE(name);
    std::vector<Json::json_pointer> objects;
    find_objects(value, Json::json_pointer(), objects);
    CHECK(!objects.empty());
    for (const Json::json_pointer& at : objects) {
      CAPTURE(at.to_string());
      Json doctored = value;
      doctored[at]["unheard_of"] = Json::object();
      CHECK(errors(name, doctored) == 1);
    }
  }
  Json run = outputs()[0].second;
  REQUIRE(errors("run", run) == 0);
  run.erase("hash");
  CHECK(errors("run", run) == 1);
  run["hash"] = 7;
  CHECK(errors("run", run) == 1);
  run["steps"] = 1.5;
  CHECK(errors("run", run) == 2);
}

TEST_CASE("a row of the table is a path of its own, a type and a sentence; pages of commands have it",
          "[cli][schemas]") {
  std::set<std::string> paths;
  const std::regex word("(string|integer|number|boolean|object|null|inf)(\\|(string|integer|number|null|inf))*");
  const std::vector<Row> all = rows();
  for (const Row& row : all) paths.insert(row.path);
  CHECK(paths.size() == all.size());
  for (const Row& row : all) {
    CAPTURE(row.path, row.type);
    const std::string type = row.type.substr(0, row.type.find_first_of("[{?"));
    CHECK((std::regex_match(type, word) || paths.count(row.type.substr(0, row.type.find('?'))) || paths.count(type)));
    CHECK((row.text.size() > 5 && row.text.back() == '.'));
    const std::string parent = row.path.substr(0, row.path.rfind('.'));
    if (row.path.find(".csv.") == std::string::npos)
      CHECK((paths.count(parent) || paths.count(parent.substr(0, parent.find('[', parent.rfind('.') + 1)))));
  }
  const Program p;
  const std::string run = p.run("doc run").out;
  for (const char* line : {".energy.kinetic", "number|null, J", ".warnings[].code"})
    CHECK(run.find(line) != std::string::npos);
  CHECK_THAT(p.run("doc kinetic").out, Catch::Contains("feder run") && Catch::Contains(".energy.kinetic"));
  CHECK_THAT(p.run("doc study").out, Catch::Contains("list .[].name") && Catch::Contains("points.csv.scene_hash"));
}

TEST_CASE("every column of a table has a row, and every row of it is a column", "[cli][schemas]") {
  const Program p;
  REQUIRE(p.run("study oscillator --methods rk4 --ladder steps:50 --repeat 0 --out d").status == 0);
  REQUIRE(p.run("stability --methods rk4 --x 0.1,1 --y 0 --bisect --out m").status == 0);
  std::set<std::string> paths;
  for (const Row& row : rows()) paths.insert(row.path);
  // a column without a row of its own is a field of the JSON beside it
  constexpr const char* tables[][3] = {{"points.csv", "d/points.csv", "study.points[]."},
                                       {"cells.csv", "m/cells.csv", "stability.rows[]."},
                                       {"limits.csv", "m/limits.csv", "stability.limits[]."}};
  std::size_t count = 0;
  for (const auto& [name, file, fields] : tables) {
    const std::string text = p.read(file), own = std::string(name) + ".";
    std::istringstream header(text.substr(0, text.find('\n')));
    std::set<std::string> columns;
    for (std::string column; std::getline(header, column, ','); ++count) {
      CAPTURE(name, column);
      CHECK(paths.count(own + column) + paths.count(fields + column) == 1);
      columns.insert(own + column);
    }
    for (const std::string& path : paths)
      if (path.starts_with(own)) CHECK(columns.count(path));
  }
  CHECK(count > 36 + 16 + 8);
  CHECK_THAT(p.run("doc stability").out,
             Catch::Contains("cells.csv.t_fail_s") && Catch::Contains("limits.csv.observed"));
  CHECK_THAT(p.run("doc test").out, Catch::Contains("golden .samples[].poses"));
}
