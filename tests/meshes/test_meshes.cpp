// Files of triangles: what OBJ, glTF and GLB become, what is refused and by which words, and that no bytes do harm.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <set>

#include "base/rng.h"
#include "feder/error.h"
#include "feder/lua.h"
#include "support/catch.h"

using namespace feder;

namespace {

lua::TriangleMesh read(const std::string& name, const std::string& content, bool weld = true,
                       const std::string& beside = {}) {
  return meshes::read({name, content, weld, [&](const std::string& wanted) {
                         if (wanted != "part.bin") throw SceneError("no file '" + wanted + "' beside it");
                         return beside;
                       }});
}

std::string error_of(const std::string& name, const std::string& content, const std::string& beside = {}) {
  try {
    read(name, content, true, beside);
  } catch (const SceneError& e) {
    return e.what();
  }
  return "none";
}

double area(const lua::TriangleMesh& m) {
  double sum = 0;
  for (std::size_t t = 0; t < m.triangles.size(); t += 3) {
    const Vec3 &a = m.vertices[m.triangles[t]], &b = m.vertices[m.triangles[t + 1]],
               &c = m.vertices[m.triangles[t + 2]];
    sum += double(cross(b - a, c - a).norm()) / 2;
  }
  return sum;
}

// Of a closed mesh: positive when its triangles look outwards.
double volume(const lua::TriangleMesh& m) {
  double sum = 0;
  for (std::size_t t = 0; t < m.triangles.size(); t += 3)
    sum +=
        double(m.vertices[m.triangles[t]].dot(cross(m.vertices[m.triangles[t + 1]], m.vertices[m.triangles[t + 2]]))) /
        6;
  return sum;
}

// Every directed edge once, and once the other way.
bool closed(const lua::TriangleMesh& m) {
  std::set<std::array<std::uint32_t, 2>> edges;
  for (std::size_t t = 0; t < m.triangles.size(); t += 3)
    for (std::size_t k = 0; k < 3; ++k)
      if (!edges.insert({m.triangles[t + k], m.triangles[t + (k + 1) % 3]}).second) return false;
  for (const auto& e : edges)
    if (!edges.contains({e[1], e[0]})) return false;
  return true;
}

const std::string kCube = R"(# a cube of 2 x 2 x 2
mtllib none.mtl
o cube
v -1 -1 -1
v 1 -1 -1
v 1 1 -1
v -1 1 -1
v -1 -1 1
v 1 -1 1
v 1 1 1
v -1 1 1
vn 0 0 1
vt 0 0
g ends
f 4 3 2 1
f 5/1 6/1 7/1 8/1
g sides
f 1//1 2//1 6//1 5//1
f -7 -6 -2 -3
f 3/1/1 4/1/1 8/1/1 7/1/1 # the top
f 4 1 5 \
 8
)";

std::uint32_t below(Rng& rng, std::uint32_t count) { return rng.next() % count; }

template <class T>
void put(std::string& bytes, T x) {
  bytes.append(reinterpret_cast<const char*>(&x), sizeof x);
}

// The tetrahedron of volume 1/6 as bytes: 4 positions, then 12 indices of 16 bits.
std::string tetrahedron() {
  std::string bytes;
  for (const float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f}) put(bytes, x);
  for (const int i : {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}) put(bytes, static_cast<std::uint16_t>(i));
  return bytes;
}

struct GltfParts {
  std::string nodes = R"({"mesh":0})", scene = "0";
  std::string primitive = R"({"attributes":{"POSITION":0},"indices":1})";
  std::string points = R"("count":4,"type":"VEC3","componentType":5126)";
  std::string indices = R"("count":12,"type":"SCALAR","componentType":5123)";
  std::string buffer = R"("uri":"part.bin","byteLength":72)";
  std::string more = "";
};

std::string gltf(const GltfParts& p) {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[)" + p.scene + R"(]}],"nodes":[)" + p.nodes +
         R"(],"meshes":[{"name":"tet","primitives":[)" + p.primitive + R"(]}],"accessors":[{"bufferView":0,)" +
         p.points + R"(},{"bufferView":1,)" + p.indices +
         R"(}],"bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":24}],"buffers":[{)" +
         p.buffer + "}]" + p.more + "}";
}

std::string glb() {
  GltfParts parts;
  parts.buffer = R"("byteLength":72)";
  std::string json = gltf(parts);
  while (json.size() % 4) json += ' ';
  std::string out = "glTF";
  put(out, std::uint32_t(2)), put(out, static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + 72));
  put(out, static_cast<std::uint32_t>(json.size())), put(out, std::uint32_t(0x4E4F534A));
  out += json;
  put(out, std::uint32_t(72)), put(out, std::uint32_t(0x004E4942));
  return out + tetrahedron();
}

}  // namespace

TEST_CASE("an OBJ file becomes triangles, whatever its faces look like", "[meshes]") {
  const lua::TriangleMesh cube = read("cube.obj", kCube);
  CHECK(cube.vertices.size() == 8);
  CHECK(cube.triangles.size() == 36);
  CHECK(closed(cube));
  CHECK(volume(cube) == Approx(8));
  // the same with line ends of other systems, and cut off behind its last face
  std::string windows;
  for (const char c : kCube) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
  CHECK(read("cube.obj", windows).triangles == cube.triangles);
  CHECK(read("cube.obj", kCube.substr(0, kCube.size() - 1)).triangles == cube.triangles);
}

TEST_CASE("concave polygons are cut within themselves, wound as they were", "[meshes]") {
  // a comb of n teeth, each of area 0.5, on a strip of area n, in a tilted plane
  const int n = GENERATE(1, 5, 40);
  std::string text, face = "f";
  const auto add = [&](double x, double y) {
    text += "v " + std::to_string(x) + " " + std::to_string(0.6 * y) + " " + std::to_string(0.8 * y) + "\n";
    face += " -" + std::to_string(3 * n + 2 - (std::ranges::count(text, '\n') - 1));
  };
  add(0, -1), add(n, -1);
  for (int i = n; i-- > 0;) add(i + 1, 0), add(i + 0.5, 1), add(i + 0.001, 0);
  const lua::TriangleMesh comb = read("comb.obj", text + face + "\n");
  CHECK(comb.triangles.size() == 3 * std::size_t(3 * n));
  CHECK(area(comb) == Approx(n + 0.4995 * n).epsilon(2e-3));
  for (std::size_t t = 0; t < comb.triangles.size(); t += 3) {
    const Vec3 &a = comb.vertices[comb.triangles[t]], &b = comb.vertices[comb.triangles[t + 1]],
               &c = comb.vertices[comb.triangles[t + 2]];
    CHECK(cross(b - a, c - a).dot(Vec3(0, Real(-0.8), Real(0.6))) >= 0);
  }
}

TEST_CASE("vertices at one place are welded, in the order of the file", "[meshes]") {
  const std::string two = "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 0 0\nv 1 1 0\nv -0 1 0\nf 2 3 4\nf 5 6 7\nf 3 5 6\n";
  const lua::TriangleMesh welded = read("two.obj", two), raw = read("two.obj", two, false);
  CHECK(welded.vertices.size() == 4);
  CHECK(welded.triangles == std::vector<std::uint32_t>{0, 1, 2, 1, 3, 2});
  CHECK(raw.vertices.size() == 7);
  CHECK(raw.triangles == std::vector<std::uint32_t>{1, 2, 3, 4, 5, 6, 2, 4, 5});
}

TEST_CASE("glTF and GLB are the same triangles, with buffers beside, within or behind", "[meshes]") {
  const lua::TriangleMesh mesh = read("tet.gltf", gltf({}), true, tetrahedron());
  CHECK(mesh.vertices.size() == 4);
  CHECK(closed(mesh));
  CHECK(volume(mesh) == Approx(1.0 / 6));
  CHECK(read("tet.glb", glb()).triangles == mesh.triangles);
  const GltfParts triangle{.primitive = R"({"attributes":{"POSITION":0}})",
                           .points = R"("count":3,"type":"VEC3","componentType":5126)",
                           .buffer = R"("byteLength":36,"uri":"data:application/octet-stream;base64,)"
                                     R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA")"};
  std::string within = gltf(triangle);
  within.replace(within.find("\"byteLength\":48"), 15, "\"byteLength\":36");
  CHECK(area(read("within.gltf", within)) == Approx(0.5));
}

TEST_CASE("nodes place what they show; a mirror does not turn it inside out", "[meshes]") {
  GltfParts parts;
  parts.nodes = R"({"children":[1,2],"translation":[10,0,0]},
      {"mesh":0,"scale":[-2,1,1],"rotation":[0,0,0.7071067811865476,0.7071067811865476]},
      {"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,3,0,0,0,5,1]},{"mesh":0})";
  const lua::TriangleMesh mesh = read("tet.gltf", gltf(parts), true, tetrahedron());
  CHECK(mesh.vertices.size() == 8);  // the last node is not in the scene
  CHECK(volume(mesh) == Approx((2 + 3) / 6.0));
  // x of the first is along -y, twice as long; the second goes up to z = 8
  CHECK((mesh.vertices[1] - Vec3(10, -2, 0)).norm() < 1e-5);
  CHECK((mesh.vertices[2] - Vec3(9, 0, 0)).norm() < 1e-5);
  CHECK((mesh.vertices[7] - Vec3(10, 0, 8)).norm() < 1e-5);
}

TEST_CASE("strips and fans are triangles, points and lines are not", "[meshes]") {
  GltfParts parts;
  parts.indices = R"("count":4,"type":"SCALAR","componentType":5123)";
  const auto with_mode = [&](int mode) {
    parts.primitive = R"({"attributes":{"POSITION":0},"indices":1,"mode":)" + std::to_string(mode) + "}";
    return gltf(parts);
  };
  std::string square;
  for (const float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, 1.f, 1.f, 0.f}) put(square, x);
  std::string strip = square, fan = square;
  for (const int i : {0, 1, 2, 3}) put(strip, static_cast<std::uint16_t>(i));
  for (const int i : {0, 1, 3, 2}) put(fan, static_cast<std::uint16_t>(i));
  strip.resize(72), fan.resize(72);
  CHECK(read("strip.gltf", with_mode(5), true, strip).triangles == std::vector<std::uint32_t>{0, 1, 2, 1, 3, 2});
  CHECK(read("fan.gltf", with_mode(6), true, fan).triangles == std::vector<std::uint32_t>{0, 1, 3, 0, 3, 2});
  CHECK(error_of("points.gltf", with_mode(0), fan) == "points.gltf: expected triangles, got none");
}

TEST_CASE("a bad OBJ file is refused with its line", "[meshes]") {
  const std::string v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  const auto check = [](const std::string& text, const std::string& wanted) {
    INFO(text);
    CHECK(error_of("a.obj", text) == "a.obj" + wanted);
  };
  check("", ": expected triangles, got none");
  check(v, ": expected triangles, got none");
  check(v + "f 1 2 2\n", ": expected triangles, got none");
  check("v 0 0\n" + v + "f 1 2 3\n", ":1: expected three coordinates, got 2");
  check(v + "v 1 nan 0\nf 1 2 3\n", ":4: expected a finite number, got 'nan'");
  check(v + "v 1 2 1e999\nf 1 2 3\n", ":4: expected a finite number, got '1e999'");
  check(v + "v 1 2 0x\x01\nf 1 2 3\n", ":4: expected a finite number, got '0x?'");
  check(v + "\n\\\n\nf 1 2 4\n", ":7: names vertex 4; there are 3 so far");
  check(v + "f 1 2 -4\n", ":4: names vertex -4; there are 3 so far");
  check(v + "f 1 2 0\n", ":4: expected the number of a vertex, got '0'");
  check(v + "f 1 2 99999999999\n", ":4: expected the number of a vertex, got '99999999999'");
  check(v + "f 1 2 x\n", ":4: expected the number of a vertex, got 'x'");
  check(v + "f 1 2 # 3\n", ":4: expected a face of at least three vertices, got 2");
  check(v + std::string("f 1 2 3\0", 8) + "\n", ":4: expected text, got a byte 0");
  CHECK(error_of("a.stl", v) == "a.stl: expected the name of an .obj, .gltf or .glb file");
}

TEST_CASE("a bad glTF file is refused with its part", "[meshes]") {
  const std::string bytes = tetrahedron();
  const auto check = [&](const GltfParts& parts, const std::string& wanted, const std::string& beside) {
    const std::string text = gltf(parts);
    INFO(text);
    CHECK_THAT(error_of("a.gltf", text, beside), Catch::Contains(wanted));
  };
  check({}, "none", bytes);
  check({}, "part.bin", bytes.substr(4));
  check({.buffer = R"("uri":"../secret.bin","byteLength":72)"}, "a.gltf: no file '../secret.bin' beside it", bytes);
  check({.nodes = R"({"mesh":7})"}, "a.gltf: node 0: expected the number of a mesh below 1, got 7", bytes);
  check({.nodes = R"({"mesh":0,"children":[0]})"}, "node 0: expected one parent, got two, or a circle", bytes);
  check({.scene = "5"}, "expected the number of a node below 1, got 5", bytes);
  check({.primitive = R"({"attributes":{"POSITION":9}})"}, "number of an accessor below 2, got 9", bytes);
  check({.primitive = R"({"attributes":{"POSITION":-1}})"}, "an accessor below 2, got -1", bytes);
  check({.primitive = R"({"attributes":{}})"}, "a.gltf", bytes);
  check({.primitive = R"({"attributes":{"POSITION":1}})"}, "expected three numbers each", bytes);
  check({.points = R"("count":2,"type":"VEC3","componentType":5126)"}, "names vertex 2; there are 2", bytes);
  check({.points = R"("count":5,"type":"VEC3","componentType":5126)"}, "its 5 elements lie outside", bytes);
  check({.points = R"("count":18446744073709551615,"type":"VEC3","componentType":5126)"}, "a.gltf", bytes);
  check({.points = R"("byteOffset":4294967295,"count":4,"type":"VEC3","componentType":5126)"}, "outside", bytes);
  check({.points = R"("count":4,"type":"VEC3","componentType":5123)"}, "expected positions as floats", bytes);
  check({.points = R"("count":4,"type":"VEC3","componentType":7)"}, "a.gltf", bytes);
  check({.indices = R"("count":12,"type":"SCALAR","componentType":5122)"}, "without a sign", bytes);
  check({.indices = R"("count":11,"type":"SCALAR","componentType":5123)"}, "three corners for each triangle", bytes);
  check({.more = R"(,"extensionsRequired":["KHR_draco_mesh_compression"])"}, "KHR_draco_mesh_compression", bytes);
  check({.more = R"(,"extras":)" + std::string(100000, '[') + std::string(100000, ']')}, "nested deeper", bytes);
  check({.nodes = R"({"mesh":0,"matrix":[1,2]})"}, "matrix: expected 16 numbers, got 2", bytes);
  std::string gone = bytes;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(gone.data() + 16, &nan, sizeof nan);
  check({}, "mesh 0 (\"tet\"), primitive 0: position 1 is not finite", gone);
  CHECK_THAT(error_of("a.glb", glb().substr(0, 300)), Catch::Contains("a.glb: is cut off"));
  CHECK_THAT(error_of("a.glb", "glTF"), Catch::Contains("a.glb: is no GLB"));
}

TEST_CASE("no bytes do harm: what is read is a mesh, everything else has an error", "[meshes]") {
  const std::string files[][2] = {{"a.obj", kCube}, {"a.gltf", gltf({})}, {"a.glb", glb()}};
  Rng rng(7);
  int meshes = 0, errors = 0;
  const auto attempt = [&](const std::string& name, const std::string& content, const std::string& beside) {
    try {
      const lua::TriangleMesh m = read(name, content, below(rng, 2) == 0, beside);
      bool good = !m.triangles.empty() && m.triangles.size() % 3 == 0;
      for (const std::uint32_t t : m.triangles) good = good && t < m.vertices.size();
      for (const Vec3& v : m.vertices) good = good && v.allFinite();
      if (!good) FAIL("no mesh: " << content);
      ++meshes;
    } catch (const SceneError& e) {
      if (std::string(e.what()).rfind(name, 0) != 0) FAIL(e.what());
      ++errors;
    }
  };
  const std::string digits = "0123456789-+eE./ \n\\{}[],\":#";
  for (int run = 0; run < 3000; ++run) {
    const auto& [name, good] = files[run % 3];
    std::string content = good, beside = tetrahedron();
    const std::uint32_t what = below(rng, 4);
    const auto size = static_cast<std::uint32_t>(content.size());
    if (what == 0) content.resize(below(rng, size));
    if (what == 3) beside[below(rng, 72)] = static_cast<char>(below(rng, 256));
    for (std::uint32_t k = below(rng, 6); content.size() > 0 && k-- > 0;) {
      const std::uint32_t at = below(rng, static_cast<std::uint32_t>(content.size()));
      content[at] = what == 1 ? static_cast<char>(below(rng, 256)) : digits[below(rng, std::uint32_t(digits.size()))];
    }
    attempt(name, content, beside);
    if (run % 30 == 0) {
      for (char& c : content) c = static_cast<char>(below(rng, 256));
      attempt(name, content, beside);
    }
  }
  CHECK(meshes > 100);
  CHECK(errors > 1000);
}
