// The schema of scenes in YAML against the program: what one takes, the other takes too, and what one refuses, so does
// the other.
#include <set>

#include "cli/program.h"
#include "support/catch.h"
#include "support/json_schema.h"
#include "yaml/document.h"

using namespace feder::test;
using Json = nlohmann::json;
namespace fs = std::filesystem;

namespace {

Json to_json(const feder::yaml::Document& d, std::uint32_t index) {
  const feder::yaml::Node& node = d.nodes[index];
  using Kind = feder::yaml::NodeKind;
  Json out;
  switch (node.kind) {
    case Kind::null: return nullptr;
    case Kind::boolean: return node.flag;
    case Kind::integer: return node.integer;
    case Kind::number: return node.number;
    case Kind::text: return node.text;
    case Kind::list:
      out = Json::array();
      for (const std::uint32_t child : node.children) out.push_back(to_json(d, child));
      return out;
    case Kind::map:
      out = Json::object();
      for (std::size_t k = 0; k + 1 < node.children.size(); k += 2)
        out[d.nodes[node.children[k]].text] = to_json(d, node.children[k + 1]);
      return out;
  }
  return out;
}

const Json& schema() {
  static const Json all = [] {
    const Program p;
    REQUIRE(p.run("doc --schemas s").status == 0);
    return Json::parse(p.read("s/scene.yaml.schema.json"));
  }();
  return all;
}

std::vector<std::string> errors(const std::string& yaml) {
  const feder::yaml::Document d = feder::yaml::read("test.yaml", yaml);
  return validate(to_json(d, d.root), schema());
}

// A bit of everything, in all forms. Lines of mistakes replace one of them.
constexpr const char* kEverything = R"(title: Everything
seconds: 0.05
picture: 0.02
camera: { target: [0, 1, 0], distance: 12, yaw: 0.5, pitch: 0.3 }
world:
  gravity: [0, -9.81, 0]
  dt: 0.01
  broad_phase: sweep_prune
  rigid: { solver: soft_step, contact_hertz: 60 }
  materials:
    ice: { friction: { static: 0.1, dynamic: 0.05 }, density: 917, color: [0.7, 0.8, 1] }
    steel: { friction: 0.4, restitution: 0.2, title: Steel }
  material_pairs:
    - { 1: ice, 2: steel, friction: 0.02 }
params:
  height: { value: 3, min: 1, max: 9, step: 1, help: crates }
  speed: 2
  mode: { value: plain, choices: [plain, fancy] }
golden: { every: 0.1, position: 0.01 }
random: 2
bodies:
  - { name: floor, type: static, shape: plane }
  - { name: slope, type: static, shape: { plane: [0.1, 1, 0, -5] } }
  - name: crate
    shape: { box: [1, 1, 1] }
    material: ice
    lock: [x, rz]
    repeat: { count: $height, step: [0, 1, 0] }
  - { name: ball, shape: { sphere: 0.5 }, position: [5, 3, 0], velocity: [$speed, 0, 0], friction: { static: 1 } }
  - { shape: { type: capsule, radius: 0.1, height: 1 }, position: [7, 3, 0], rotation: { axis: [0, 0, 1], angle: 1 } }
  - { name: slab, shape: { type: box, size: [2, 1, 3] }, position: [12, 3, 0], tags: [flat], mass: 20, sensor: all }
  - { shape: { hull: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]] }, position: [15, 3, 0], group: 2, mask: 0xff }
  - { type: static, shape: { mesh: [[[20, 0, 0], [21, 0, 0], [20, 0, 1]], [[1, 3, 2]]] }, color: "#ff8800" }
  - position: [25, 3, 0]
    shape:
      compound:
        - { shape: { box: [1, 1, 1] } }
        - { shape: { sphere: 1 }, position: [2, 0, 0] }
regions:
  - { name: zone, box: [[0, 0, 0], [1, 1, 1]] }
joints:
  - { name: link, type: ball, a: ball, b: slab, anchor: [6, 3, 0] }
  - { type: hinge, a: slab, axis: [0, 1, 0], limits: [-1, 1], motor: { speed: 1, max_torque: 5 } }
nets:
  - name: net
    points: [[0, 30, 0], [1, 30, 0], [2, 30, 0]]
    masses: 0.1
    springs: [[1, 2], { i: 2, j: 3, stiffness: 50 }]
    pins: [1]
    integrator: rk45
    integrator_options: { tolerance: 0.001 }
cloths:
  - size: [1, 0.5]
    resolution: [8, 5]
    position: [30, 3, 0]
    pins: [top_left, 2, left_clamped]
    wind: { drag: 0.5 }
    max_strain: false
ropes:
  - { from: [30, 5, 0], to: [31, 5, 0], segments: 6, pins: [first_clamped, 3], bend: 0.01 }
  - { points: [[30, 6, 0], [31, 6, 0], [31, 6, 1]], pins: [last] }
soft_bodies:
  - { shape: { box: [0.2, 0.2, 0.2] }, resolution: 2, position: [30, 8, 0], young: 1000, pins: [1] }
  - { points: [[30, 9, 0], [31, 9, 0], [30, 10, 0], [30, 9, 1]], tetrahedra: [[1, 2, 3, 4]], poisson: 0.4 }
fluids:
  - spacing: 0.1
    solver: pbf
    fill: { box: [[40, 0, 0], [40.5, 0.5, 0.5]] }
    emitter: [{ position: [42, 2, 0], direction: [0, -1, 0], speed: 1, limit: 100 }]
    drain: { box: [[39, -2, -1], [41, -1, 1]] }
forces:
  - { kind: drag, linear: 0.1, on: flat }
  - { each: "-k * x", params: { k: 0.5 }, on: [flat] }
check: expect(world:is_finite())
)";

struct SchemaMistake {
  const char *line, *instead, *place;
};
constexpr SchemaMistake kSchemaMistakes[] = {
    {"seconds: 0.05", "secnds: 0.05", "/secnds: is not allowed"},
    {"seconds: 0.05", "seconds: -1", "/seconds: is not above"},
    {"seconds: 0.05", "seconds: long", "/seconds: "},
    {"golden: {", "golden: { evry: 1, ", "/golden/evry"},
    {"  dt: 0.01", "  dt: 2", "/world/dt: is above"},
    {"  dt: 0.01", "  dimension: 4", "/world/dimension: is above"},
    {"sweep_prune", "sweep_prone", "/world/broad_phase"},
    {"contact_hertz: 60", "contact_herz: 60", "/world/rigid/contact_herz"},
    {"density: 917", "density: 0", "/world/materials/ice/density"},
    {"value: 3, min", "min", "/params/height"},
    {"type: static, shape: plane", "type: statik, shape: plane", "/bodies/0/type"},
    {"type: static, shape: plane", "type: static, shape: plain", "/bodies/0/shape"},
    {"box: [1, 1, 1] }\n    mat", "box: [1, 1, 1, 1] }\n    mat", "/bodies/2/shape"},
    {"box: [1, 1, 1] }\n    mat", "box: [1, -1, 1] }\n    mat", "/bodies/2/shape"},
    {"box: [1, 1, 1] }\n    mat", "bx: [1, 1, 1] }\n    mat", "/bodies/2/shape"},
    {"lock: [x, rz]", "lock: [x, rq]", "/bodies/2/lock"},
    {"step: [0, 1, 0]", "step: 1", "/bodies/2/repeat/step"},
    {"count: $height", "cont: $height", "/bodies/2/repeat/cont"},
    {"friction: { static: 1 }", "friction: { statik: 1 }", "/bodies/3/friction"},
    {"friction: { static: 1 }", "densty: 1", "/bodies/3/densty"},
    {"mass: 20", "mass: heavy", "/bodies/5/mass"},
    {"sensor: all", "sensor: some", "/bodies/5/sensor"},
    {"type: ball, a: ball", "type: bal, a: ball", "/joints/0/type"},
    {"limits: [-1, 1]", "limits: [-1]", "/joints/1/limits"},
    {"motor: { speed: 1", "motor: { sped: 1", "/joints/1/motor/sped"},
    {"integrator: rk45", "integrator: rk46", "/nets/0/integrator"},
    {"stiffness: 50", "stifness: 50", "/nets/0/springs/1"},
    {"resolution: [8, 5]", "resolution: [8]", "/cloths/0/resolution"},
    {"max_strain: false", "max_strain: none", "/cloths/0/max_strain"},
    {"limit: 100", "limits: 100", "/fluids/0/emitter"},
    {"kind: drag", "kind: drug", "/forces/0/kind"},
    {"params: { k: 0.5 }", "params: { k: text }", "/forces/1/params/k"},
    {"check: expect(world:is_finite())", "check: 3", "/check"},
};

// Of the schema and all within it.
template <class F>
void each_schema(const Json& at, F&& f) {
  if (at.is_object()) f(at);
  for (const Json& inner : at)
    if (inner.is_structured()) each_schema(inner, f);
}

}  // namespace

TEST_CASE("all scenes in YAML are as their schema says, and run", "[cli][schemas][yaml]") {
  int count = 0;
  for (const auto& entry : fs::recursive_directory_iterator(FEDER_SOURCE_DIR "/scenes")) {
    if (entry.path().extension() != ".yaml" && entry.path().extension() != ".yml") continue;
    CAPTURE(entry.path().string());
    CHECK(errors(read_file(entry.path())) == std::vector<std::string>{});
    ++count;
  }
  CHECK(count >= 1);
  CHECK(errors(kEverything) == std::vector<std::string>{});
  const Program p;
  p.write("everything.yaml", kEverything);
  const Outcome out = p.run("run everything.yaml --check");
  CAPTURE(out.err);
  CHECK(out.status == 0);
}

TEST_CASE("a mistake in a scene in YAML is refused by the schema and by the program", "[cli][schemas][yaml]") {
  for (const SchemaMistake& mistake : kSchemaMistakes) {
    CAPTURE(mistake.instead);
    std::string text = kEverything;
    const std::size_t at = text.find(mistake.line);
    REQUIRE(at != std::string::npos);
    text.replace(at, std::string(mistake.line).size(), mistake.instead);
    const std::vector<std::string> told = errors(text);
    REQUIRE(told.size() == 1);
    CHECK_THAT(told[0], Catch::StartsWith(mistake.place));
    const Program p;
    p.write("mistake.yaml", text);
    const Outcome out = p.run("run mistake.yaml --steps 1");
    CAPTURE(out.err);
    CHECK(out.status == 3);
  }
}

TEST_CASE("the schema has every option of its makers with sentence and unit, and defaults fit",
          "[cli][schemas][yaml]") {
  const Json pages = Program().run("doc --json").json();
  const std::map<std::string, const char*> lists = {
      {"world:body", "bodies"},  {"world:region", "regions"}, {"world:joint", "joints"}, {"world:net", "nets"},
      {"world:cloth", "cloths"}, {"world:rope", "ropes"},     {"world:fluid", "fluids"}, {"world:soft", "soft_bodies"}};
  const Json& known = schema()["properties"];
  std::size_t rows = 0;
  for (const Json& page : pages) {
    const std::string title = page["title"];
    const auto list = lists.find(title);
    if (list == lists.end() && title != "feder.world" && page["owner"] != "options") continue;
    const Json& of = list != lists.end() ? known[list->second]["items"]
                     : title == "feder.world"
                         ? known["world"]
                         : known["world"]["properties"][page["title"].get<std::string>().substr(6)];
    for (const Json& row : page["rows"]) {
      const std::string name = row["name"], unit = row["unit"];
      if (name.find('.') != std::string::npos) continue;
      CAPTURE(title, name);
      REQUIRE(of["properties"].contains(name));
      const std::string text = of["properties"][name]["description"];
      CHECK_THAT(text, Catch::Contains(row["text"].get<std::string>()) && Catch::Contains(unit));
      ++rows;
    }
  }
  CHECK(rows > 120);
  int defaults = 0;
  each_schema(schema(), [&](const Json& one) {
    if (!one.contains("default") || one.contains("$schema") || !one.contains("description")) return;
    CAPTURE(one.dump());
    CHECK(validate(one["default"], one, schema()) == std::vector<std::string>{});
    ++defaults;
  });
  CHECK(defaults > 80);
}

TEST_CASE("feder new writes a scene in YAML with its schema beside it", "[cli][schemas][yaml]") {
  const Program p;
  const Outcome made = p.run("new first.yaml --json");
  REQUIRE(made.status == 0);
  CHECK(made.json()["files"] == Json({"first.yaml", ".feder/scene.yaml.schema.json"}));
  const std::string text = p.read("first.yaml");
  CHECK_THAT(text, Catch::StartsWith("# yaml-language-server: $schema=.feder/scene.yaml.schema.json\n"));
  CHECK(Json::parse(p.read(".feder/scene.yaml.schema.json")) == schema());
  CHECK(errors(text) == std::vector<std::string>{});
  const Outcome out = p.run("test first.yaml");
  CAPTURE(out.err);
  CHECK(out.status == 0);
  CHECK(p.run("new first.yaml").status == 1);
}
