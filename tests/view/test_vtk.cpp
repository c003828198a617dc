// feder export -o file.vtp: XML that is read back here, array by array, against what the scene says of itself.
#include <cmath>
#include <cstring>
#include <map>
#include <regex>

#include "cli/program.h"
#include "support/catch.h"

using feder::test::Outcome;

namespace {

std::string from_base64(const std::string& text) {
  static const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  REQUIRE(text.size() % 4 == 0);
  std::string out;
  for (std::size_t i = 0; i < text.size(); i += 4) {
    std::uint32_t three = 0;
    int there = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t digit = digits.find(text[i + k]);
      three = three << 6 | static_cast<std::uint32_t>(digit == std::string::npos ? 0 : digit);
      there += digit != std::string::npos;
    }
    for (int k = 0; k + 1 < there; ++k) out += static_cast<char>(three >> (16 - 8 * k) & 255);
  }
  return out;
}

struct Vtp {
  std::map<std::string, std::vector<double>> arrays;  // "Verts.offsets", "velocity"
  std::map<std::string, std::string> piece;           // NumberOfPoints ...
  double time = NAN;
};

template <class T>
std::vector<double> numbers(const std::string& bytes) {
  std::uint64_t size = 0;
  REQUIRE(bytes.size() >= sizeof size);
  std::memcpy(&size, bytes.data(), sizeof size);
  REQUIRE(bytes.size() == sizeof size + size);
  std::vector<T> values(size / sizeof(T));
  if (size > 0) std::memcpy(values.data(), bytes.data() + sizeof size, size);
  return {values.begin(), values.end()};
}

// Every element is closed in the order it was opened; binary arrays are decoded.
Vtp read_vtp(const std::string& text) {
  Vtp vtp;
  REQUIRE(text.starts_with("<?xml"));
  std::vector<std::string> open;
  static const std::regex tag(R"(<(\?xml|!--|/?)(\w*)([^>]*?)(/?)>([^<]*))"), attribute(R"re((\w+)="([^"]*)")re");
  for (std::sregex_iterator at(text.begin(), text.end(), tag), end; at != end; ++at) {
    const std::smatch& m = *at;
    if (m[1] == "?xml" || m[1] == "!--") continue;
    if (m[1] == "/") {
      REQUIRE(!open.empty());
      CHECK(open.back() == m[2]);
      open.pop_back();
      continue;
    }
    std::map<std::string, std::string> given;
    const std::string inside = m[3];
    for (std::sregex_iterator a(inside.begin(), inside.end(), attribute); a != end; ++a) given[(*a)[1]] = (*a)[2];
    if (m[2] == "Piece") vtp.piece = given;
    if (m[2] == "VTKFile") CHECK((given["byte_order"] == "LittleEndian" && given["header_type"] == "UInt64"));
    if (given["Name"] == "TimeValue") vtp.time = std::stod(m[5]);
    if (given["format"] == "binary") {
      const std::string bytes = from_base64(m[5]), type = given["type"];
      const std::string parent = open.back() == "PointData" || open.back() == "Points" ? "" : open.back() + ".";
      auto& values = vtp.arrays[parent + given["Name"]];
      if (type == "Float32") values = numbers<float>(bytes);
      if (type == "Float64") values = numbers<double>(bytes);
      if (type == "Int32") values = numbers<std::int32_t>(bytes);
      if (type == "Int64") values = numbers<std::int64_t>(bytes);
    }
    if (m[4] != "/") open.push_back(m[2]);
  }
  CHECK(open.empty());
  return vtp;
}

const char* const kPoints = R"(
local feder = require "feder"
return feder.scene { title = "Points", seconds = 0.2, picture = 0.1,
  build = function(world)
    world:body { name = "ground", type = "static", shape = feder.plane() }
    world:net { name = "flag -- <1>", points = { { 3, 2, 0 }, { 4, 2, 0 }, { 4, 3, 0 } },
                springs = { { 1, 2 }, { 2, 3 } }, faces = { { 1, 2, 3 } },
                velocities = { { 1, 0, 0 }, { 1, 0, 0 }, { 1, 0, 0 } } }
    world:cloth { name = "sheet", size = { 1, 1 }, resolution = { 3, 4 }, position = { 0, 5, 0 } }
    local water = world:fluid { name = "water", spacing = 0.1, density = 900 }
    water:fill { box = { { 0, 0.1, 0 }, { 0.3, 0.4, 0.2 } } }
  end }
)";

}  // namespace

TEST_CASE("export writes particles and points as VTK", "[view][files]") {
  const feder::test::Program p;
  p.write("scene.lua", kPoints);
  const Outcome o = p.run("export scene.lua -o a.vtp --at 0");
  INFO(o.err);
  REQUIRE(o.status == 0);
  Vtp v = read_vtp(p.read("a.vtp"));
  CHECK(v.time == 0);
  const std::size_t count = 3 + 12 + 18;
  CHECK(v.piece["NumberOfPoints"] == std::to_string(count));
  CHECK(v.piece["NumberOfVerts"] == "18");
  CHECK(v.piece["NumberOfLines"] == "2");
  CHECK(v.piece["NumberOfPolys"] == std::to_string(1 + 12));
  CHECK(v.arrays["Points"].size() == 3 * count);
  CHECK(v.arrays["velocity"].size() == 3 * count);
  CHECK(v.arrays["object"].size() == count);
  CHECK(v.arrays["Polys.offsets"].size() == 13);
  CHECK(v.arrays["Lines.connectivity"] == std::vector<double>{0, 1, 1, 2});
  CHECK(std::vector<double>(v.arrays["Points"].begin(), v.arrays["Points"].begin() + 9) ==
        std::vector<double>{3, 2, 0, 4, 2, 0, 4, 3, 0});
  CHECK(v.arrays["velocity"][0] == 1);
  CHECK(std::isnan(v.arrays["density"][0]));
  CHECK(v.arrays["density"].back() > 300);
  CHECK(v.arrays["density"].back() < 1000);
  CHECK(v.arrays["radius"].back() == Approx(0.05));
  for (const char* cells : {"Verts", "Lines", "Polys"})
    for (const double i : v.arrays[std::string(cells) + ".connectivity"])
      CHECK((i >= 0 && i < static_cast<double>(count)));
  CHECK_THAT(p.read("a.vtp"), Catch::Contains("net &quot;flag -_ &lt;1&gt;&quot;"));
}

TEST_CASE("a series of VTK files has an index with the times", "[view][files]") {
  const feder::test::Program p;
  p.write("scene.lua", kPoints);
  p.write("bodies.lua",
          "local feder = require 'feder'\nreturn feder.scene { build = function(world) world:body { shape = "
          "feder.sphere(1) } end }");
  const Outcome o = p.run("export scene.lua -o out/a.vtp --every 0.1");
  CHECK(o.status == 1);  // no such folder
  CHECK_THAT(o.err, Catch::Contains("cannot be written: No such file"));
  REQUIRE(p.run("export scene.lua -o a.vtp --every 0.1 -q").status == 0);
  const std::string index = p.read("a.pvd");
  for (int i = 0; i < 3; ++i) {
    const std::string file = "a0000" + std::to_string(i) + ".vtp";
    const Vtp v = read_vtp(p.read(file));
    CHECK(v.time == Approx(0.1 * i));
    const auto at = index.find("file=\"" + file + "\"");
    REQUIRE(at != std::string::npos);
    const auto time = index.rfind("timestep=\"", at) + 10;
    CHECK(std::stod(index.substr(time)) == v.time);
  }
  CHECK(p.shell("ls *.vtp").out == "a00000.vtp\na00001.vtp\na00002.vtp\n");
  CHECK(p.run("export bodies.lua -o b.vtp").status == 1);
  CHECK(p.run("export scene.lua -o a.glb --every 0.1").status == 2);
  CHECK(p.run("export scene.lua -o a.vtp --every 0").status == 2);
}

TEST_CASE("exports and pictures that cannot be written fail, and leave what was there", "[view][files]") {
  const feder::test::Program p;
  p.write("scene.lua", kPoints);
  for (const std::string ending : {"gltf", "glb", "obj", "ply", "vtp", "png", "gif"}) {
    const std::string command = ending == "png" || ending == "gif" ? "render" : "export";
    p.shell("mkdir -p full && ln -sf /dev/full full/a." + ending);
    for (const std::string folder : {"nowhere", "full"}) {
      const std::string file = folder + "/a." + ending;
      const Outcome o =
          p.run(command + " scene.lua --seconds 0.1 -o " + file + (command == "render" ? " --size 60x40" : ""));
      CAPTURE(file, o.out, o.err);
      if (command == "render" && o.err.find("OpenGL") != std::string::npos) continue;
      CHECK(o.status == 1);
      CHECK(o.err.find("cannot be written") != std::string::npos);
    }
  }
  CHECK(p.shell("ls full").out.find("part") == std::string::npos);
}
