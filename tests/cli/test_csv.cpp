// feder run --csv and --track: columns, exact numbers, what comes late and goes early, and files that cannot be
// written.
#include <cstdlib>
#include <map>

#include "cli/program.h"
#include "support/catch.h"

using namespace feder::test;

namespace {

struct Csv {
  std::vector<std::string> headers;
  std::vector<std::vector<std::string>> rows;

  const std::string& text(std::size_t row, const std::string& header) const {
    const auto at = std::find(headers.begin(), headers.end(), header);
    CAPTURE(header, headers);
    REQUIRE(at != headers.end());
    return rows.at(row).at(static_cast<std::size_t>(at - headers.begin()));
  }
  double number(std::size_t row, const std::string& header) const {
    return std::strtod(text(row, header).c_str(), nullptr);
  }
};

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> out(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const bool twice = quoted && line[i] == '"' && i + 1 < line.size() && line[i + 1] == '"';
    if (twice)
      out.back() += line[++i];
    else if (line[i] == '"')
      quoted = !quoted;
    else if (line[i] == ',' && !quoted)
      out.emplace_back();
    else
      out.back() += line[i];
  }
  return out;
}

// Every row has a cell for each header.
Csv parse(const std::string& text) {
  Csv csv;
  std::istringstream lines(text);
  REQUIRE(text.ends_with('\n'));
  std::string line;
  std::getline(lines, line);
  csv.headers = cells(line);
  while (std::getline(lines, line)) {
    csv.rows.push_back(cells(line));
    CHECK(csv.rows.back().size() == csv.headers.size());
  }
  return csv;
}

// A ball that prints what the file should hold; a plot from 0.2 s on; a crate from 0.2 to 0.3 s.
const char* const kScene = R"(local feder = require 'feder'
return feder.scene { title = 'Probe', seconds = 0.5, world = { dt = 1 / 60 },
  build = function(world, scene)
    scene.ball = world:body { name = 'ball', shape = feder.sphere(0.5), position = { 0.1, 3, 0 },
      velocity = { 1 / 3, 0, 0 }, angular_velocity = { 0.7, 2, 0 } }
    world:after(0.2, function() scene.crate = world:body { name = 'crate, "late"', shape = feder.box(1, 1, 1) } end)
    world:after(0.3, function() scene.crate:destroy() end)
  end,
  update = function(world, scene)
    local v = { scene.ball:position() }
    for _, f in ipairs { 'rotation', 'velocity', 'angular_velocity' } do
      for _, x in ipairs { scene.ball[f](scene.ball) } do v[#v + 1] = x end
    end
    for _, x in ipairs { world:energy() } do v[#v + 1] = x end
    for i, x in ipairs(v) do v[i] = ('%.17g'):format(x) end
    print(('%.17g '):format(world:time()) .. table.concat(v, ' '))
    if world:time() > 0.2 then feder.plot('height, "m"', v[2] / 3) end
  end }
)";

}  // namespace

TEST_CASE("a row per step, whose numbers read back exactly", "[cli][csv]") {
  const Program p;
  p.write("scene.lua", kScene);
  const Outcome o = p.run("run scene.lua --csv out.csv --track ball");
  CAPTURE(o.err);
  REQUIRE(o.status == 0);
  const Csv csv = parse(p.read("out.csv"));
  REQUIRE(csv.rows.size() == 31);  // the start, and 30 steps
  const std::vector<std::string> names = {
      "time [s]",        "ball.x [m]",      "ball.y [m]",    "ball.z [m]",    "ball.qx",       "ball.qy",
      "ball.qz",         "ball.qw",         "ball.vx [m/s]", "ball.vy [m/s]", "ball.vz [m/s]", "ball.wx [rad/s]",
      "ball.wy [rad/s]", "ball.wz [rad/s]", "kinetic [J]",   "potential [J]", "elastic [J]"};
  std::istringstream printed(o.out);
  for (std::size_t row = 1; row <= 30; ++row) {
    CHECK(csv.text(row, "step") == std::to_string(row));
    for (const std::string& name : names) {
      double said = 0;
      printed >> said;
      CAPTURE(row, name, csv.text(row, name));
      const bool exact = name.find('[') != std::string::npos && name.find('.') == std::string::npos;  // in double
      if (exact)
        CHECK(csv.number(row, name) == said);
      else
        CHECK(static_cast<float>(csv.number(row, name)) == static_cast<float>(said));
    }
    printed.ignore(1, '\n');
  }
  CHECK(csv.number(0, "ball.x [m]") == 0.1);  // shortest text: no 0.10000000149
  CHECK(csv.text(0, "ball.x [m]") == "0.1");
}

TEST_CASE("columns that come late are empty before, and what is gone is empty after", "[cli][csv]") {
  const Program p;
  p.write("scene.lua", kScene);
  REQUIRE(p.run("run scene.lua -q --csv out.csv --track 'crate*' --track 'bal?'").status == 0);
  const Csv csv = parse(p.read("out.csv"));
  const std::string crate = "crate, \"late\".y [m]", height = "height, \"m\"";
  for (std::size_t row = 0; row < csv.rows.size(); ++row) {
    CAPTURE(row);
    CHECK(csv.text(row, crate).empty() == (row < 12 || row >= 18));
    CHECK(csv.text(row, height).empty() == (row <= 12));
    if (row > 12) CHECK(csv.number(row, height) == Approx(csv.number(row, "ball.y [m]") / 3));
  }
}

TEST_CASE("what is made of points has a centre, a box and a velocity", "[cli][csv]") {
  const Program p;
  p.write("scene.lua", scene(R"(
    world:net { name = 'net', points = { { 0, 5, 0 }, { 2, 5, 0 } }, masses = { 1, 3 }, springs = { { 1, 2 } } }
    world:cloth { name = 'cloth', size = { 1, 2 }, resolution = { 5, 9 }, position = { 0, 9, 0 } }
    local f = world:fluid { name = 'water', spacing = 0.1 }
    f:fill { box = { { 0, 0, 0 }, { 0.4, 0.4, 0.4 } } }
    world:fluid { name = 'none' }
    world:body { shape = feder.sphere(1), position = { 9, 9, 9 } })"));
  const Outcome o = p.run("run scene.lua -q --seconds 0.05 --csv out.csv --track '*'");
  CAPTURE(o.err);
  REQUIRE(o.status == 0);
  const Csv csv = parse(p.read("out.csv"));
  CHECK(csv.number(0, "net.x [m]") == 1.5);
  CHECK(csv.number(0, "net.min_x [m]") == 0);
  CHECK(csv.number(0, "net.max_x [m]") == 2);
  CHECK(csv.text(0, "net.count") == "2");
  CHECK(csv.number(0, "cloth.max_z [m]") - csv.number(0, "cloth.min_z [m]") == Approx(2));
  CHECK(csv.text(0, "cloth.count") == "45");
  CHECK(csv.number(0, "water.y [m]") == Approx(0.2).margin(0.051));
  CHECK(csv.text(0, "water.count") == "64");
  CHECK(csv.text(0, "none.count") == "0");
  CHECK(csv.text(0, "none.x [m]").empty());
  CHECK(csv.number(3, "net.vy [m/s]") == Approx(-9.81 * 0.05).epsilon(0.02));
  CHECK(std::any_of(csv.headers.begin(), csv.headers.end(), [](const auto& h) { return h.starts_with("body #"); }));
}

TEST_CASE("names that fit nothing are a usage error, and the file is there", "[cli][csv]") {
  const Program p;
  p.write("scene.lua", scene(kBall));
  const Outcome o = p.run("run scene.lua -q --csv out.csv --track bll");
  CHECK(o.status == 2);
  CHECK(o.err == "feder run: --track: nothing with a place is called 'bll'; did you mean 'ball'?\n");
  CHECK(parse(p.read("out.csv")).rows.size() == 31);
  CHECK(p.run("run scene.lua --track ball").status == 2);
  const Outcome json = p.run("run scene.lua --json --csv out.csv --track bll --check");
  CHECK(json.status == 2);
  CHECK(json.json()["interrupted"] == false);
  CHECK(json.json()["check"]["passed"] == 1);
  p.write("odd.lua", scene("world:body { name = 'a[1]', shape = feder.sphere(1) }"));
  CHECK(p.run("run odd.lua -q --csv out.csv --track 'a[1]' --track 'a?1?'").status == 0);
  p.write("twice.lua", scene(std::string(kBall) + "\n" + kBall));
  REQUIRE(p.run("run twice.lua -q --csv out.csv --track ball").status == 0);
  CHECK(parse(p.read("out.csv")).text(0, "ball#2.y [m]") == "3");
}

TEST_CASE("plain scripts have rows, and a file changes no run", "[cli][csv]") {
  const Program p;
  p.write("plain.lua",
          "local feder = require 'feder'\nlocal w = feder.world { dt = 0.01 }\nw:body { name = 'b', shape = "
          "feder.sphere(1) }\nfor i = 1, 5 do w:step() feder.plot('i', i) end");
  REQUIRE(p.run("run plain.lua -q --csv out.csv --track b").status == 0);
  const Csv csv = parse(p.read("out.csv"));
  REQUIRE(csv.rows.size() == 5);
  for (std::size_t row = 0; row < 5; ++row) CHECK(csv.text(row, "i") == std::to_string(row + 1));
  p.write("scene.lua", kScene);
  CHECK(p.run("run scene.lua --json").json()["hash"] ==
        p.run("run scene.lua --json --csv out.csv --track ball").json()["hash"]);
}

TEST_CASE("an interrupted run leaves the rows of its steps", "[cli][csv]") {
  const Program p;
  p.write("scene.lua",
          "local feder = require 'feder'\nreturn feder.scene { seconds = 1e6, build = function(world) "
          "world:body { name = 'b', shape = feder.sphere(1) } end, update = function(world) if "
          "world:step_count() == 100 then print 'ready' end end }");
  const Outcome o =
      p.shell("{ '" FEDER_BINARY_DIR
              "/feder' run scene.lua --json --csv out.csv --track b & pid=$!; for i in "
              "$(seq 200); do grep -q ready .err && break; sleep 0.05; done; kill -INT $pid; wait $pid; }");
  CAPTURE(o.err);
  CHECK(o.status == 130);
  const Csv csv = parse(p.read("out.csv"));
  CHECK(csv.rows.size() == o.json()["steps"].get<std::size_t>() + 1);
  CHECK(csv.text(csv.rows.size() - 1, "step") == std::to_string(csv.rows.size() - 1));
  CHECK(p.shell("ls").out == "out.csv\nscene.lua\n");
}

TEST_CASE("a file that cannot be written is a failure, and what was there stays", "[cli][csv]") {
  const Program p;
  p.write("scene.lua", scene(kBall));
  p.write("kept.csv", "old\n");
  for (const char* file : {"/dev/full", "no/such/folder.csv", "."}) {
    const Outcome o = p.run("run scene.lua -q --csv " + std::string(file));
    CAPTURE(file, o.err);
    CHECK(o.status == 1);
    CHECK(o.err.starts_with(std::string(file) + ": cannot be written"));
    CHECK(count_lines(o.err) == 1);
  }
  p.write("broken.lua", scene("error 'no'"));
  CHECK(p.run("run broken.lua --csv kept.csv").status == 3);
  CHECK(p.read("kept.csv") == "old\n");
  CHECK(p.shell("ls").out == "broken.lua\nkept.csv\nscene.lua\n");
}
