// Cloth in scripts: what it is attached by.
#include "support/script.h"

using namespace feder::test;

namespace {
const char* const kSheet =
    "local plank = world:body{ name = 'plank', type = 'kinematic', shape = feder.box(2, 0.1, 2), position = {0, 1, 0} "
    "} "
    "local flag = world:cloth{ size = {1, 0.5}, resolution = {4, 3}, position = {0, 0.9, 0} } ";
}  // namespace

TEST_CASE("cloth is attached by the names that pins take, each vertex where it is", "[lua][cloth]") {
  CHECK(output_of(std::string(kSheet) + R"(
    flag:destroy()
    local corners = { top_left = 1, top_right = 4, bottom_left = 9, bottom_right = 12 }
    local sides = { top = {1, 2, 3, 4}, bottom = {9, 10, 11, 12}, left = {1, 5, 9}, right = {4, 8, 12} }
    local function follows(name, list)
      local sheet = world:cloth{ size = {1, 0.5}, resolution = {4, 3}, position = {0, 0.9, 0}, self_collision = false }
      assert(sheet:attach(name, plank) == sheet)
      local held = {}
      for _, i in ipairs(list) do held[i] = true end
      local before = {}
      for i = 1, 12 do before[i] = { sheet:point(i) } end
      for k = 1, 30 do
        plank:move_to(0.01 * k, 1, 0)
        world:step()
      end
      local right = true
      for i = 1, 12 do
        local x, y, z = sheet:point(i)
        local with = math.abs(x - before[i][1] - 0.3) < 1e-3 and math.abs(y - before[i][2]) < 1e-3
        right = right and with == (held[i] == true)
      end
      sheet:destroy()
      plank:set_position(0, 1, 0)
      return right
    end
    for name, i in pairs(corners) do print(name, follows(name, { i })) end
    for name, list in pairs(sides) do print(name, follows(name, list)) end
  )") == "bottom_left\ttrue\nbottom_right\ttrue\ntop_left\ttrue\ntop_right\ttrue\nbottom\ttrue\nleft\ttrue\n"
         "right\ttrue\ntop\ttrue\n");
}

TEST_CASE("a name that a cloth has not is refused, and so is one place for many vertices", "[lua][cloth]") {
  CHECK(error_of(std::string(kSheet) + "flag:attach('top_lef', plank)") ==
        "test.lua:1: cloth:attach: unknown name 'top_lef'; did you mean 'top_left'?; known: top_left, top_right, "
        "bottom_left, bottom_right, top, bottom, left, right, each with _clamped");
  CHECK(error_of(std::string(kSheet) + "flag:attach('top', plank, 0, 0, 0)") ==
        "test.lua:1: cloth:attach: expected no place for 'top': it is several points");
  CHECK(error_of(std::string(kSheet) + "flag:attach('top_clamped', plank)") ==
        "test.lua:1: cloth:attach: 'top_clamped': an attachment holds places, not slopes; leave _clamped out");
  CHECK(error_of(std::string(kSheet) + "local mesh = world:cloth{ vertices = {{0,0,0},{1,0,0},{0,0,1}}, triangles = "
                                       "{{1,3,2}} } mesh:attach('top', plank)") ==
        "test.lua:1: cloth:attach: 'top': only sheets have named sides; give vertex numbers");
  CHECK(output_of(std::string(kSheet) + "flag:attach('top_left', plank, 0, 0, 0) flag:attach(2, plank)") == "");
}

TEST_CASE("the warning of too few solver substeps names options that end it for now", "[lua][cloth]") {
  const auto warnings = [](const std::string& options) {
    return output_of(
        "world:on('warning', function(e) print(e.code, e.message) end) "
        "world:cloth{ size = {0.4, 0.3}, resolution = {33, 25}, area_density = 0.05, pins = {'left'}" +
        options + " } world:step()");
  };
  const std::string told = warnings(", stretch_error = 1e-5");
  CAPTURE(told);
  REQUIRE_THAT(told, Catch::StartsWith("substep_cap") && Catch::Contains("max_substeps = ") &&
                         Catch::Contains(" or stretch_error = "));
  for (const char* option : {"max_substeps = ", "stretch_error = "}) {
    // behind the sentence on what there is now
    const std::string cure = told.substr(told.find(option, told.find(": it ")));
    const std::string given = cure.substr(0, cure.find(' ', cure.find("= ") + 2));
    CAPTURE(given);
    CHECK(warnings(", stretch_error = 1e-5, " + given).find("substep_cap") == std::string::npos);
  }
  CHECK(warnings(", max_substeps = 400") == "");
}

TEST_CASE("cloth:tangles counts crossings", "[lua][cloth]") {
  CHECK(output_of(std::string(kSheet) + R"(
    print(flag:tangles())
    local x, y, z = flag:point(7)
    flag:set_point(1, x + 0.1, y - 0.1, z + 0.03)
    flag:set_point(5, x + 0.1, y + 0.1, z + 0.03)
    print(flag:tangles() > 0)
  )") == "0\ntrue\n");
}
