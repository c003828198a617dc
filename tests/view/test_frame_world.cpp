// Frames of worlds: what is in them, that collecting changes nothing, and that it allocates nothing once warm.
#include "feder/cloth.h"
#include "view/drawing.h"
#include "view/palette.h"

using namespace feder;
using namespace feder::view;
using feder::test::add_box;
using feder::test::add_ground;
using feder::test::collected;

namespace {

ObjectId add_chain(World& world, int count) {
  NetDesc d;
  for (int i = 0; i < count; ++i) {
    d.points.push_back(vec3(Real(i), 5, 0));
    d.masses.push_back(1);
    if (i > 0) {
      SpringDesc s;
      s.i = static_cast<std::uint32_t>(i - 1), s.j = static_cast<std::uint32_t>(i);
      d.springs.push_back(s);
    }
  }
  return world.need<Springs>().add_net(d);
}

// Of a scene as it is built.
Frame collected_scene(const char* text) {
  lua::Script script({});
  script.load_string(text, "scene.lua");
  script.build();
  Collector collector;
  Frame f;
  collector.collect(*script.world(), script.appearance(), {}, f);
  return f;
}

}  // namespace

TEST_CASE("a frame shows bodies where they are", "[view]") {
  World world({}, catalog());
  add_ground(world);
  const ObjectId box = add_box(world, vec3(1, 2, 3), vec3(4, 5, 6), BodyType::dynamic, "crate1");
  add_box(world, vec3(1, 1, 1), vec3(0, 3, 0), BodyType::fixed);
  const Frame f = collected(world);
  REQUIRE(f.instances.size() == 2);
  REQUIRE(f.batches.size() == 1);
  REQUIRE(f.grounds.size() == 1);
  const Instance& i = f.instances[0];
  CHECK(i.object == box.slot);
  CHECK(i.position[0] == 4.0f);
  CHECK(i.position[2] == 6.0f);
  CHECK(i.scale[1] == 2.0f);
  CHECK(f.moving.low[1] == 4.0f);
  CHECK(f.moving.high[1] == 6.0f);
  CHECK(f.bounds.low[0] == -0.5f);
  CHECK((f.instances[1].flags & kFixed) != 0);
}

TEST_CASE("events of the step are named where they happened", "[view]") {
  World world({}, catalog());
  add_ground(world);
  add_box(world, vec3(1, 1, 1), vec3(0, Real(0.5), 0));
  world.step();
  CHECK(collected(world).labels.empty());
  Toggles toggles;
  toggles.marks = true;
  const Frame f = collected(world, toggles);
  REQUIRE(f.labels.size() == 1);
  CHECK(std::string_view(f.labels[0].text) == "contact_begin");
  CHECK(std::fabs(f.labels[0].position.y) < 0.1f);
}

TEST_CASE("sleeping bodies are marked and greyer", "[view]") {
  World world({}, catalog());
  add_ground(world);
  const ObjectId box = add_box(world, vec3(1, 1, 1), vec3(0, Real(0.5), 0));
  const Color awake = collected(world).instances[0].color;
  world.need<Rigid>().sleep(box);
  const Frame f = collected(world);
  CHECK((f.instances[0].flags & kAsleep) != 0);
  CHECK(f.instances[0].color == asleep(awake));
  CHECK(!(f.instances[0].color == awake));
}

TEST_CASE("a layer that is off is not collected, and none is collected twice", "[view]") {
  World world({}, catalog());
  add_ground(world);
  add_box(world, vec3(1, 1, 1), vec3(0, Real(0.5), 0), BodyType::dynamic, "box");
  add_chain(world, 4);
  for (int i = 0; i < 10; ++i) world.step();
  const Frame usual = collected(world);
  CHECK(usual.lines.size() == 3);
  CHECK(usual.points.size() == 4);
  CHECK(usual.overlay_lines.empty());
  CHECK(usual.labels.empty());
  Toggles none;
  for (const ToggleInfo& t : toggle_list()) none.*t.field = false;
  const Frame empty = collected(world, none);
  CHECK(empty.instances.empty());
  CHECK(empty.grounds.empty());
  CHECK(empty.lines.empty());
  CHECK(empty.points.empty());
  Toggles all;
  for (const ToggleInfo& t : toggle_list()) all.*t.field = true;
  const Frame full = collected(world, all);
  CHECK(full.labels.size() == 1);
  CHECK(full.plots.size() > 3);
  CHECK(full.overlay_lines.size() > 4 * 3);  // four corners rest on the plane: normal and cross each
}

TEST_CASE("toggles are found by name", "[view]") {
  Toggles t;
  set_toggles(t, "contacts,joints,-springs");
  CHECK(t.contacts);
  CHECK(t.joints);
  CHECK(!t.springs);
  set_toggles(t, "pressure,-points");
  CHECK(std::string(t.point_scalar) == "pressure");
  CHECK_FALSE(t.points);
  CHECK_THROWS_WITH(set_toggles(t, "contakts"), Catch::Contains("did you mean 'contacts'"));
  set_toggles(t, "volumes=3,joints");
  CHECK(t.volumes);
  CHECK(t.volume_level == 3);
  set_toggles(t, "-volumes");
  CHECK_FALSE(t.volumes);
  for (const char* bad : {"volumes=", "volumes=-1", "volumes=2x", "volumes=65", "joints=1"})
    CHECK_THROWS_WITH(set_toggles(t, bad), Catch::Contains("a level from 0 to 64, got '"));
  set_toggles(t, "cells=2");
  CHECK(t.cells);
  CHECK(t.cell_level == 2);
  CHECK(t.volume_level == 3);
  CHECK_THROWS_WITH(set_toggles(t, "volume=3"), Catch::Contains("did you mean 'volumes'"));
}

TEST_CASE("volumes are drawn by level, where a mesh stands", "[view]") {
  World world({}, catalog());
  add_box(world, vec3(1, 1, 1), vec3(0, 9, 0));
  add_ground(world);
  std::vector<Vec3> points;
  std::vector<std::uint32_t> triangles;
  for (int i = 0; i < 8; ++i)
    for (const Vec3& p : {vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 0, 1)})
      triangles.push_back(static_cast<std::uint32_t>(points.size())), points.push_back(p + vec3(Real(2 * i), 0, 0));
  BodyDesc d;
  d.type = BodyType::fixed, d.position = vec3(5, 0, 0);
  d.shape = make_shape("mesh", {.points = points, .triangles = triangles, .mesh_index = {"bvh", "aabb", "", 1}});
  world.need<Rigid>().add_body(d);
  Toggles toggles;
  set_toggles(toggles, "volumes");
  const Frame whole = collected(world, toggles);
  REQUIRE(whole.outlines.size() == 12 + 12);  // of the box, and of the mesh
  CHECK(whole.deeper_volumes);
  CHECK(std::ranges::count_if(whole.outlines, [](const Line& l) { return l.a.y == 9.5f && l.b.y == 9.5f; }) == 4);
  float left = 1e9f, right = -1e9f;
  for (const Line& l : whole.outlines)
    if (l.a.y < 1) left = std::min({left, l.a.x, l.b.x}), right = std::max({right, l.a.x, l.b.x});
  CHECK(left == 5);
  CHECK(right == 5 + 15);
  Collector collector;
  Frame f;
  for (const int level : {1, 2, 3, 4, 0}) {
    toggles.volume_level = level;
    collector.collect(world, nullptr, toggles, f);
    CHECK(f.outlines.size() == std::size_t(level == 0 ? 24 : level < 3 ? 12 << level : 12 * 8));
    CHECK(f.deeper_volumes == (level < 3));
    CHECK(f.notes.empty());
  }
  CHECK(subject_of(f).longest_side() == subject_of(collected(world)).longest_side());
}

TEST_CASE("what the broad phase searches by is drawn, level by level", "[view]") {
  const std::string broad =
      GENERATE(as<std::string>{}, "tree", "octree", "kd_tree", "grid", "hash_grid", "cullide", "sweep_prune");
  CAPTURE(broad);
  WorldDesc desc;
  desc.options.set("broad_phase", broad);
  World world(desc, catalog());
  for (int i = 0; i < 40; ++i) add_box(world, vec3(1, 1, 1), vec3(Real(3 * (i % 8)), Real(1.9 * (i / 8)), 0));
  world.step();
  Toggles toggles;
  CHECK(collected(world, toggles).outlines.empty());
  Collector collector;
  Frame f;
  std::size_t levels = 0;
  for (set_toggles(toggles, "cells"); levels < 30; ++levels, ++toggles.cell_level) {
    collector.collect(world, nullptr, toggles, f);
    CAPTURE(levels, f.outlines.size());
    CHECK(f.outlines.size() % 12 == 0);
    CHECK(f.outlines.empty() == (broad == "sweep_prune" || broad == "cullide"));  // views see all apart
    CHECK(f.notes.empty() == !f.outlines.empty());
    Aabb all;
    for (const Line& l : f.outlines) all.include(vec3(l.a.x, l.a.y, l.a.z)), all.include(vec3(l.b.x, l.b.y, l.b.z));
    if (broad == "tree" || broad == "octree" || broad == "kd_tree") {  // nodes of a level hold all boxes
      CHECK(all.lo[0] <= Real(-0.49));
      CHECK(all.hi[0] >= Real(21.49));
    }
    if (!f.deeper_cells) break;
  }
  const bool tree = broad == "tree" || broad == "octree" || broad == "kd_tree";
  CHECK((levels >= 2) == tree);
}

TEST_CASE("volumes beyond what a picture can show are left out, and a note says so", "[view]") {
  World world({}, catalog());
  std::vector<Vec3> points;
  std::vector<std::uint32_t> triangles;
  for (int i = 0; i < 5000; ++i)
    for (const Vec3& p : {vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 0, 1)})
      triangles.push_back(static_cast<std::uint32_t>(points.size())), points.push_back(p + vec3(Real(2 * i), 0, 0));
  BodyDesc d;
  d.type = BodyType::fixed, d.name = "row";
  d.shape = make_shape("mesh", {.points = points, .triangles = triangles, .mesh_index = {"bvh", "sphere", "", 1}});
  world.need<Rigid>().add_body(d);
  Toggles toggles;
  set_toggles(toggles, "volumes=20");
  const Frame f = collected(world, toggles);
  CHECK(f.outlines.size() == 50000);
  REQUIRE(f.notes.size() == 1);
  CHECK(std::string(f.notes[0].text) == "body \"row\": of its volumes at level 20 the first 50000 edges are drawn");
}

TEST_CASE("collecting changes nothing: the hash of a run is the same with and without", "[view]") {
  const auto run = [](bool drawn) {
    World world({}, catalog());
    add_ground(world);
    for (int i = 0; i < 8; ++i)
      add_box(world, vec3(1, 1, 1), vec3(Real(0.1) * Real(i % 3), Real(0.6) + Real(1.1) * Real(i), 0));
    add_chain(world, 6);
    Toggles all;
    for (const ToggleInfo& t : toggle_list()) all.*t.field = true;
    Collector collector;
    Frame frame;
    std::vector<std::uint64_t> hashes;
    for (int step = 0; step < 120; ++step) {
      world.step();
      if (drawn) collector.collect(world, nullptr, all, frame);
      hashes.push_back(world.hash());
    }
    return hashes;
  };
  CHECK(run(true) == run(false));
}

TEST_CASE("frames are reused: nothing moves once warm", "[view]") {
  World world({}, catalog());
  add_ground(world);
  for (int i = 0; i < 50; ++i) add_box(world, vec3(1, 1, 1), vec3(Real(2 * i), 2, 0));
  add_chain(world, 20);
  Collector collector;
  Frame frame;
  collector.collect(world, nullptr, {}, frame);
  const auto* first = frame.instances.data();
  const auto* lines = frame.lines.data();
  for (int i = 0; i < 5; ++i) {
    world.step();
    collector.collect(world, nullptr, {}, frame);
    CHECK(frame.instances.data() == first);
    CHECK(frame.lines.data() == lines);
  }
}

TEST_CASE("cloth that trembles is drawn at rest, and never farther off than its thickness", "[view]") {
  WorldDesc wd;
  wd.gravity = Vec3::Zero(), wd.sleeping = false;
  World world(wd, catalog());
  ClothDesc d;
  d.nx = d.ny = 5;
  for (std::uint32_t i = 0; i < 25; ++i) d.pins.push_back(i);  // the test moves it
  Cloth& cloth = world.need<Cloth>();
  const ObjectId id = cloth.add_cloth(d);
  Toggles calm;
  calm.temporal = true;
  Collector collector, plain;
  Frame f, now;
  const Vec3 rest = cloth.point(id, 12);
  double off = 0, drawn = 0;
  const auto show = [&](const Vec3& at) {
    for (std::size_t i = 0; i < 25; ++i) cloth.set_point(id, i, cloth.point(id, i) + (at - cloth.point(id, 12)));
    world.step();
    collector.collect(world, nullptr, calm, f);
    plain.collect(world, nullptr, {}, now);
    REQUIRE(f.vertices.size() == 25);
    const double y = f.vertices[12].position.y, x = f.vertices[12].position.x;
    off = std::hypot(x - at[0], y - at[1]), drawn = y - rest[1];
  };
  const double trembles = 2e-4;
  for (int k = 0; k < 60; ++k) {
    show(rest + Vec3(0, Real(k % 2 ? trembles : -trembles), 0));
    if (k >= 30) CHECK(std::fabs(drawn) < trembles / 4);
    CHECK(double(now.vertices[12].position.y - rest[1]) == Approx(k % 2 ? trembles : -trembles).margin(1e-6));
  }
  // what moves lags by the same whether it is slow or fast: a sixtieth of 0.2 m
  for (const double speed : {0.1, 5.0}) {
    const Vec3 from = cloth.point(id, 12);
    for (int k = 1; k <= 90; ++k) show(from + Vec3(Real(speed * k / 60), 0, 0));
    CHECK(off == Approx(0.2 / 60).epsilon(0.02));
  }
  show(rest + Vec3(0, 40, 0));
  CHECK(off <= double(d.thickness) * 1.001);
}

TEST_CASE("colours come from groups of names and stay", "[view]") {
  CHECK(name_stem("crate12") == "crate");
  CHECK(name_stem("plank 3") == "plank");
  CHECK(name_stem("42") == "");
  CHECK(group_color("crate", 3) == group_color("crate", 3));
  CHECK(!(group_color("crate", 3) == group_color("crate", 4)));
  CHECK(!(group_color("crate", 3) == group_color("plank", 3)));
}

TEST_CASE("a script's colours and faces reach the frame", "[view]") {
  const Frame f = collected_scene(R"(
    local feder = require "feder"
    return feder.scene { title = "t", build = function(world)
      world:body { shape = feder.box(1, 1, 1), color = { 1, 0, 0 } }
      world:body { shape = feder.box(1, 1, 1), position = { 3, 0, 0 }, color = "#00ff80" }
      world:net { points = { { 0, 5, 0 }, { 1, 5, 0 }, { 1, 6, 0 }, { 0, 6, 0 } }, masses = 1,
        springs = { { 1, 2 } }, faces = { { 1, 2, 3, 4 } } }
    end })");
  REQUIRE(f.instances.size() == 2);
  CHECK(f.instances[0].color == Color{255, 0, 0, 255});
  CHECK(f.instances[1].color == Color{0, 255, 128, 255});
  REQUIRE(f.meshes.size() == 1);
  CHECK(f.meshes[0].index_count == 6);
  CHECK(std::abs(std::abs(f.vertices[0].normal[2]) - 1) < 1e-6f);
}

TEST_CASE("transparent bodies come after the others", "[view]") {
  const Frame f = collected_scene(R"(
    local feder = require "feder"
    return feder.scene { title = "t", build = function(world)
      world:body { shape = feder.box(1, 1, 1), color = "#102030", transparency = 0.6 }
      world:body { shape = feder.sphere(1), position = { 3, 0, 0 }, transparency = 0 }
      world:body { type = "static", shape = feder.mesh({{0,0,0},{1,0,0},{0,0,1}}, {{1,2,3}}, { index = "bsp" }),
                   transparency = 1 }
    end })");
  REQUIRE(f.batches.size() == 3);
  CHECK_FALSE(f.batches[0].translucent);
  CHECK(f.batches[1].translucent);
  CHECK(f.batches[2].translucent);
  CHECK(f.instances[f.batches[1].first].color == Color{16, 32, 48, 102});
  CHECK(f.instances[f.batches[2].first].color.a == 0);
  CHECK(f.geometries[f.batches[2].geometry]->ordered);
  CHECK_FALSE(f.geometries[f.batches[1].geometry]->ordered);
}

TEST_CASE("a scene says when and from where a picture tells most", "[view]") {
  lua::Script script({});
  script.load_string(
      "local feder = require 'feder'; return feder.scene { picture = 0.5, seconds = 2, build = function() end,"
      " camera = { target = { 1, 2, 3 }, yaw = 0.5 } }",
      "scene.lua");
  CHECK(script.picture() == 0.5);
  CHECK(script.camera().has_target);
  CHECK(script.camera().target[2] == 3);
  CHECK(script.camera().yaw == 0.5);
  CHECK(!script.camera().has_distance);
  lua::Script wrong({});
  CHECK_THROWS_WITH(wrong.load_string("require('feder').scene { build = print, camera = { distanse = 1 } }", "w.lua"),
                    Catch::Contains("w.lua:1") && Catch::Contains("did you mean 'distance'?"));
}

TEST_CASE("mistakes in colours name the choices", "[view]") {
  const auto error = [](const std::string& color) {
    lua::Script script({});
    std::string what;
    try {
      script.load_string(
          "local feder = require 'feder'; feder.world{}:body{ shape = feder.sphere(1), color = " + color + " }",
          "c.lua");
    } catch (const lua::ScriptError& e) {
      what = e.what();
    }
    return what;
  };
  CHECK_THAT(error("'organge'"), Catch::Contains("c.lua:1") && Catch::Contains("did you mean 'orange'?"));
  CHECK_THAT(error("{1, 2, 3}"), Catch::Contains("color[2]"));
  CHECK_THAT(error("17"), Catch::Contains("{r, g, b}"));
  CHECK(error("'orange'").empty());
}
