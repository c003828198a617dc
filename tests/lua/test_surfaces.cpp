// Surfaces of parts of compounds and of triangles of meshes: mistakes are named, and what they state stays theirs
// whatever the body's numbers are set to.
#include "support/script.h"

using namespace feder::test;

namespace {

const char* const kWorld =
    "local feder = require 'feder'; local v, t = {{-9,0,-9},{9,0,-9},{-9,0,9},{9,0,9}}, {{1,3,2,1},{2,3,4}}; "
    "local world = feder.world{ materials = { ice = { friction = 0 }, wood = { friction = 0.5 } }, "
    "material_pairs = { { 'wood', 'ice', friction = 0.2 } } }; ";

// A block of friction 1 slides from 4 m/s on what `floor` says; its speed after 1 s.
std::string slid(const std::string& floor, const std::string& block = "friction = 1", const std::string& then = "") {
  const Ran ran =
      run("local ground = world:body{ type = 'static', " + floor +
              " } local box = world:body{ shape = feder.box(0.5, 0.2, 0.5), position = {-6, 0.1, -4}, "
              "velocity = {4, 0, 0}, " +
              block + " } " + then + " for _ = 1, 60 do world:step() end print(('%.2f'):format((box:velocity())))",
          {}, kWorld);
  CHECK(ran.error == "");
  return ran.output;
}

}  // namespace

TEST_CASE("surfaces of shapes: mistakes say file, line, expected and given", "[lua][options]") {
  const char* const mistakes[][2] = {
      {"feder.mesh(v, t)",
       "test.lua:1: feder.mesh.triangles[1]: names a surface, but { surfaces = } is missing behind the triangles"},
      {"feder.mesh(v, {{1,3,2,2}}, { surfaces = { { friction = 1 } } })",
       "test.lua:1: feder.mesh.triangles[1]: its surface: expected a whole number from 1 to 1, got 2"},
      {"feder.mesh(v, t, { surfaces = { { friction = -1 } } })",
       "test.lua:1: feder.mesh.surfaces[1].friction: expected a number of at least 0, got -1"},
      {"feder.mesh(v, t, { surfaces = { { restitution = 2 } } })",
       "test.lua:1: feder.mesh.surfaces[1].restitution: expected a number from 0 to 1, got 2"},
      {"feder.mesh(v, t, { surface = {} })",
       "test.lua:1: feder.mesh: unknown option 'surface'; did you mean 'surfaces'?"},
      {"feder.compound{ { shape = feder.sphere(1), frction = 1 } }",
       "test.lua:1: feder.compound[1]: unknown option 'frction'; did you mean 'friction'?"},
      {"world:body{ shape = feder.compound{ { shape = feder.sphere(1), material = 'mud' } } }",
       "test.lua:1: world:body.shape: a surface of it has the unknown material 'mud'; known: ice, wood"},
  };
  for (const auto& [text, message] : mistakes) {
    CAPTURE(text);
    CHECK(run(text, {}, kWorld).error.find(message) == 0);
  }
}

TEST_CASE("what a triangle or a part states takes the place of the body's", "[lua]") {
  const auto mesh = [](const char* surface) {
    return std::string("friction = 1, shape = feder.mesh(v, t, { surfaces = { { ") + surface + " } } })";
  };
  CHECK(slid(mesh("restitution = 0")) == "0.00\n");  // friction stays the body's
  CHECK(slid(mesh("friction = 0")) == "4.00\n");
  CHECK(slid(mesh("material = 'ice'")) == "4.00\n");
  CHECK(slid(mesh("material = 'ice', friction = 1")) == "0.00\n");         // its own number before its material's
  CHECK(slid(mesh("material = 'ice'"), "material = 'wood'") == "2.04\n");  // the pair: 4 - 0.2 g
  CHECK(slid(mesh("surface_velocity = {3, 0, 0}")) == "3.00\n");
  CHECK(slid(mesh("friction = 0"), "friction = 1", "ground:set_friction(1)") == "4.00\n");
  CHECK(slid(mesh("restitution = 0"), "friction = 1", "ground:set_friction(0)") == "4.00\n");
  // a floor of two boxes, of which the block meets the second
  const auto boxes = [](const char* surface) {
    return std::string(
               "friction = 1, shape = feder.compound{ { shape = feder.box(20, 1, 1), position = {0, -0.5, 20} }, "
               "{ shape = feder.box(20, 1, 20), position = {0, -0.5, 0}, ") +
           surface + " } }";
  };
  CHECK(slid(boxes("restitution = 0")) == "0.00\n");
  CHECK(slid(boxes("friction = 0")) == "4.00\n");
  CHECK(slid(boxes("material = 'ice'")) == "4.00\n");
  CHECK(slid(boxes("material = 'ice'"), "material = 'wood'") == "2.04\n");
  CHECK(slid(boxes("surface_velocity = {3, 0, 0}")) == "3.00\n");
  CHECK(slid(boxes("friction = 0"), "friction = 1", "ground:set_friction(1)") == "4.00\n");
  CHECK(slid(boxes("restitution = 0"), "friction = 1", "ground:set_friction(0)") == "4.00\n");
}

TEST_CASE("a body that lies across two surfaces rests on both", "[lua]") {
  // a wide block with half of its weight on ice: half the friction
  const Ran ran =
      run("world:body{ type = 'static', friction = 1, shape = "
          "feder.mesh({{-9,0,-9},{9,0,-9},{-9,0,0},{9,0,0},{-9,0,9},{9,0,9}},"
          " {{1,3,2,1},{2,3,4,1},{3,5,4},{4,5,6}}, { surfaces = { { friction = 0 } } }) } "
          "local box = world:body{ shape = feder.box(1, 0.1, 2), position = {-6, 0.05, 0}, velocity = {4, 0, 0}, "
          "friction = 0.36, lock = {'ry'} } for _ = 1, 60 do world:step() end local _, y = box:position() "
          "print(('%.1f %.2f'):format((box:velocity()), y))",
          {}, kWorld);
  CHECK(ran.error == "");
  CHECK(ran.output == "1.1 0.05\n");  // 4 - sqrt(0.36) g / 2
}
