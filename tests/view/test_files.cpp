// The files that feder render and feder export write: sizes, numbers of frames, structure, and the Khronos validator
// where node and its gltf-validator package are at hand (FEDER_GLTF_VALIDATOR: the folder that holds node_modules).
#include <gif_lib.h>

#include "cli/program.h"
#include "support/catch.h"

using feder::test::Outcome;

namespace {

std::uint32_t big_endian(const std::string& s, std::size_t at) {
  std::uint32_t x = 0;
  for (std::size_t i = 0; i < 4; ++i) x = x << 8 | static_cast<unsigned char>(s.at(at + i));
  return x;
}

struct GifInfo {
  int width = 0, height = 0, frames = 0;
};
GifInfo gif_info(const std::string& file) {
  int error = 0;
  GifFileType* gif = DGifOpenFileName(file.c_str(), &error);
  REQUIRE(gif);
  REQUIRE(DGifSlurp(gif) == GIF_OK);
  const GifInfo info{gif->SWidth, gif->SHeight, gif->ImageCount};
  DGifCloseFile(gif, &error);
  return info;
}

// A tower, a ball that comes later, and a net with faces.
const char* const kScene = R"(
local feder = require "feder"
return feder.scene { title = "All kinds", seconds = 1, picture = 0.5, camera = { yaw = 0.2 },
  build = function(world)
    world:body { name = "ground", type = "static", shape = feder.plane() }
    for i = 1, 3 do world:body { name = "crate " .. i, shape = feder.box(1, 1, 1), position = { 0, i - 0.4, 0 } } end
    world:body { shape = feder.capsule(0.2, 1), position = { 2, 2, 0 }, rotation = { axis = { 0, 0, 1 }, angle = 1 } }
    world:body { shape = feder.hull { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } }, position = { -2, 1, 0 } }
    world:net { name = "flag", points = { { 3, 2, 0 }, { 4, 2, 0 }, { 4, 3, 0 }, { 3, 3, 0 } }, masses = 1, pins = { 4 },
      springs = { { 1, 2 }, { 2, 3 }, { 3, 4 }, { 4, 1 }, { 1, 3 } }, faces = { { 1, 2, 3, 4 } } }
    world:after(0.4, function() world:body { name = "late", shape = feder.sphere(0.3), position = { 0, 5, 0 } } end)
  end }
)";

}  // namespace

TEST_CASE("render writes a PNG of the asked size", "[view][files]") {
  const feder::test::Program p;
  p.write("scene.lua", kScene);
  const Outcome o = p.run("render scene.lua -o a.png --size 200x120 --show contacts,labels");
  INFO(o.err);
  REQUIRE(o.status == 0);
  const std::string png = p.read("a.png");
  CHECK(png.substr(1, 3) == "PNG");
  CHECK(big_endian(png, 16) == 200);
  CHECK(big_endian(png, 20) == 120);
  CHECK(png.size() > 2000);
}

TEST_CASE("render writes GIFs, folders of frames, and sheets", "[view][files]") {
  const feder::test::Program p;
  p.write("many/scene.lua", kScene);
  p.write("many/other.lua", kScene);
  p.write("many/broken.lua",
          "local feder = require 'feder'\nreturn feder.scene { build = function(world) world:body { } end }");
  REQUIRE(p.run("render many/scene.lua -o a.gif --size 120x80 --seconds 0.5 --fps 10").status == 0);
  std::string folder = p.shell("pwd").out;
  folder.pop_back();
  const GifInfo gif = gif_info(folder + "/a.gif");
  CHECK(gif.width == 120);
  CHECK(gif.height == 80);
  CHECK(gif.frames == 5);
  REQUIRE(p.run("render many/scene.lua -o frames/ --size 60x40 --seconds 0.2 --fps 20").status == 0);
  CHECK(p.shell("ls frames").out == "frame00000.png\nframe00001.png\nframe00002.png\nframe00003.png\n");
  const Outcome sheet = p.run("render many -o sheet.png --size 100x60");
  CHECK(sheet.status == 1);  // one scene is broken: its error is in its place
  CHECK_THAT(sheet.err, Catch::Contains("broken.lua:2"));
  CHECK(big_endian(p.read("sheet.png"), 16) > 300);
}

TEST_CASE("mistakes on the command line are named", "[view][files]") {
  const feder::test::Program p;
  p.write("scene.lua", kScene);
  const auto fails = [&](const std::string& arguments, const std::string& words) {
    const Outcome o = p.run(arguments);
    CAPTURE(arguments, o.err);
    CHECK(o.status == 2);
    CHECK_THAT(o.err, Catch::Contains(words));
  };
  fails("render scene.lua -o a.png --size 20", "1280x720");
  fails("render scene.lua -o a.png --show bones", "known: shapes");
  fails("render scene.lua -o a.png --camera 1,2,3,4", "yaw,pitch");
  fails("render scene.lua -o a.bmp", "file.png");
  fails("export scene.lua -o a.fbx", ".gltf");
  const Outcome nothing = p.shell("FEDER_GL=nonsense '" FEDER_BINARY_DIR "/feder' render scene.lua -o a.png");
  CHECK(nothing.status == 1);
  CHECK_THAT(nothing.err, Catch::Contains("expected egl or osmesa"));
}

TEST_CASE("a fluid too large for a surface is named once, with the cure", "[view][files][liquid]") {
  const feder::test::Program p;
  p.write("sea.lua", R"(local feder = require "feder"
return feder.scene { seconds = 0.1, build = function(world)
  local sea = world:fluid { name = "sea", spacing = 0.02, max_particles = 200000, transparency = 0.7 }
  sea:fill { box = { { 0, 0, 0 }, { 1, 1, 0.9 } } }
end })");
  const std::string render = "render sea.lua --size 64x48 --quiet --at 0 ";
  Outcome o = p.run(render + "-o a.png");
  CHECK(o.status == 0);
  CHECK_THAT(o.err, Catch::Contains("sea.lua: fluid \"sea\" is drawn as drops: its surface is built up to 100000"));
  CHECK_THAT(o.err, Catch::Contains("--show liquid"));
  o = p.run(render + "-o a.gif --seconds 0.02 --fps 100");
  CHECK(o.status == 0);
  CHECK(std::count(o.err.begin(), o.err.end(), '\n') == 1);
  CHECK(p.run(render + "-o a.png --show liquid").err.empty());
  p.write("wrong.lua", "local feder = require 'feder'\nlocal w = feder.world {}\nw:fluid { transparency = 1.5 }\n");
  o = p.run("run wrong.lua");
  CHECK(o.status != 0);
  CHECK_THAT(o.err, Catch::Contains("wrong.lua:3: world:fluid.transparency: expected"));
}

TEST_CASE("rendering does not change a run", "[view][files]") {
  const feder::test::Program p;
  p.write("scene.lua", std::string(kScene).insert(
                           std::string(kScene).rfind("build ="),
                           "update = function(world) if world:step_count() == 30 then print(world:hash()) end end,\n"));
  const Outcome plain = p.run("run scene.lua --seconds 0.5 --quiet");
  CHECK(plain.out.size() == 17);
  // the same steps under a renderer, which shows no output of a scene but its errors
  p.write("hash.lua",
          std::string(kScene).insert(
              std::string(kScene).rfind("build ="),
              "update = function(world) if world:step_count() == 30 then error('H' .. world:hash()) end end,\n"));
  const Outcome drawn = p.run("render hash.lua -o frames/ --size 32x24 --seconds 0.5 --fps 60");
  CHECK_THAT(drawn.err, Catch::Contains("H" + plain.out.substr(0, 16)));
}

TEST_CASE("exported glTF is what the specification says", "[view][files]") {
  const feder::test::Program p;
  p.write("scene.lua", kScene);
  for (const std::string name : {"a.gltf", "a.glb"}) {
    const Outcome o = p.run("export scene.lua -o " + name + " --fps 10");
    INFO(o.err);
    REQUIRE(o.status == 0);
    const char* modules = std::getenv("FEDER_GLTF_VALIDATOR");
    const Outcome valid =
        p.shell("node '" FEDER_SOURCE_DIR "/tests/view/validate.js' " + name + " '" + (modules ? modules : ".") + "'");
    CAPTURE(name, valid.out, valid.err);
    if (valid.status == 3 || valid.status == 127)
      WARN("no node or no gltf-validator: structure only");
    else
      CHECK(valid.status == 0);
  }
  const auto gltf = nlohmann::json::parse(p.read("a.gltf"));
  CHECK(gltf["asset"]["version"] == "2.0");
  // ground, 3 crates, capsule, hull, the late ball, a pinned point, faces, springs
  CHECK(gltf["nodes"].size() == 10);
  CHECK(gltf["animations"].size() == 1);
  const auto& animation = gltf["animations"][0];
  int translations = 0, scales = 0, weights = 0;
  for (const auto& channel : animation["channels"]) {
    const std::string path = channel["target"]["path"];
    translations += path == "translation", scales += path == "scale", weights += path == "weights";
    const auto& sampler = animation["samplers"][channel["sampler"].get<std::size_t>()];
    const std::size_t in = gltf["accessors"][sampler["input"].get<std::size_t>()]["count"];
    const std::size_t out = gltf["accessors"][sampler["output"].get<std::size_t>()]["count"];
    CHECK(in == 11);
    CHECK(out == (path == "weights" ? in * 10 : in));
  }
  CHECK(translations >= 6);
  CHECK(scales == 1);  // the late ball
  CHECK(weights == 2);
  for (const auto& accessor : gltf["accessors"]) {
    const auto& view = gltf["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    CHECK(view.value("byteOffset", std::size_t(0)) + view["byteLength"].get<std::size_t>() <=
          gltf["buffers"][0]["byteLength"].get<std::size_t>());
  }
}

TEST_CASE("the skin of a soft body is exported with a morph target for each sample", "[view][files]") {
  const feder::test::Program p;
  p.write("scene.lua", R"(
    local feder = require "feder"
    return feder.scene { title = "Jelly", seconds = 0.5, build = function(world)
      world:soft { name = "jelly", shape = feder.box(0.2, 0.2, 0.2), resolution = 2, position = { 0, 3, 0 } }
    end })");
  REQUIRE(p.run("export scene.lua -o a.gltf --fps 10").status == 0);
  const auto gltf = nlohmann::json::parse(p.read("a.gltf"));
  REQUIRE(gltf["meshes"].size() == 1);
  CHECK(gltf["meshes"][0]["name"] == "jelly");
  const auto& skin = gltf["meshes"][0]["primitives"][0];
  CHECK(gltf["accessors"][skin["indices"].get<std::size_t>()]["count"] == 3 * 48);  // 6 faces of 4 squares
  REQUIRE(skin["targets"].size() == 5);
  // the last is half a second of free fall below
  const auto& fallen = gltf["accessors"][skin["targets"][4]["POSITION"].get<std::size_t>()];
  CHECK(fallen["min"][1].get<double>() == Approx(-0.5 * 9.81 * 0.25).epsilon(0.01));
  CHECK(fallen["max"][1].get<double>() == Approx(-0.5 * 9.81 * 0.25).epsilon(0.01));
}

TEST_CASE("OBJ and PLY of a moment", "[view][files]") {
  const feder::test::Program p;
  p.write("scene.lua", kScene);
  REQUIRE(p.run("export scene.lua -o a.obj --at 0.1").status == 0);
  const std::string obj = p.read("a.obj");
  CHECK_THAT(obj, Catch::Contains("mtllib a.mtl"));
  CHECK_THAT(obj, Catch::Contains("o crate_2"));
  CHECK_THAT(p.read("a.mtl"), Catch::Contains("newmtl color_"));
  // indices are within the vertices, and all corners are used with their own normals
  std::istringstream lines(obj);
  std::size_t vertices = 0, normals = 0, largest = 0, faces = 0;
  for (std::string line; std::getline(lines, line);) {
    vertices += line.starts_with("v "), normals += line.starts_with("vn ");
    if (!line.starts_with("f ")) continue;
    ++faces;
    std::istringstream words(line.substr(2));
    for (std::string word; words >> word;) largest = std::max(largest, static_cast<std::size_t>(std::stoul(word)));
  }
  CHECK(vertices == normals);
  CHECK(largest == vertices);
  CHECK(faces > 100);
  REQUIRE(p.run("export scene.lua -o a.ply --at 0.1").status == 0);
  const std::string ply = p.read("a.ply");
  const auto number = [&](const std::string& after) { return std::stoul(ply.substr(ply.find(after) + after.size())); };
  const std::size_t body = ply.find("end_header\n") + 11;
  CHECK(number("element face ") == faces);
  CHECK(ply.size() - body == 28 * number("element vertex ") + 13 * faces);
}
