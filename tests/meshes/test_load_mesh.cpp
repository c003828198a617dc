// feder.load_mesh in scripts: what it returns goes into cloths and shapes, and which files it reads.
#include <filesystem>
#include <fstream>

#include "feder/lua.h"
#include "support/catch.h"

using namespace feder;

namespace {

struct MeshFolder {
  std::filesystem::path path = std::filesystem::temp_directory_path() / "feder_meshes_test";
  MeshFolder() {
    std::filesystem::remove_all(path);
    std::filesystem::create_directories(path / "scene/models");
  }
  ~MeshFolder() { std::filesystem::remove_all(path); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(path / name) << text; }
};

const char* const kSquare = "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0.5 1 0.5\n";

// What the script prints, or its error.
std::string run(const MeshFolder& f, const std::string& text, lua::HostOptions options) {
  f.write("scene/main.lua", "local feder = require 'feder'\n" + text);
  std::string output;
  options.print = [&](std::string_view line) { output += line; };
  lua::Script script(std::move(options));
  try {
    script.load_file(f.path / "scene/main.lua");
  } catch (const lua::ScriptError& e) {
    output += e.what();
  }
  return output;
}

lua::HostOptions with_meshes() {
  lua::HostOptions options;
  options.load_mesh = meshes::read;
  return options;
}

}  // namespace

TEST_CASE("a mesh from a file is a cloth, a mesh, a hull, a field", "[meshes]") {
  const MeshFolder f;
  f.write("scene/models/roof.obj", std::string(kSquare) + "f 5 2 1\nf 5 3 2\nf 5 4 3\nf 5 1 4\nf 1 2 3 4\n");
  const std::string output = run(f, R"(
    local m = feder.load_mesh "models/roof.obj"
    print(#m.vertices, #m.triangles, m.vertices[5][2], m.triangles[1][1], math.type(m.triangles[1][1]))
    local w = feder.world{ gravity = {0, 0, 0} }
    local c = w:cloth{ vertices = m.vertices, triangles = m.triangles, area_density = 0.2, position = {0, 5, 0} }
    print(c:count())  -- vertices, triangles, edges
    w:body{ type = "static", shape = feder.mesh(m.vertices, m.triangles) }
    w:body{ shape = feder.hull(m.vertices), density = 300, position = {5, 0, 0} }
    print(feder.sdf{ mesh = m, spacing = 0.1 } ~= nil)
    w:step()
    print(#feder.load_mesh("models/roof.obj", { weld = false }).vertices))",
                                 with_meshes());
  CHECK(output == "5\t6\t1.0\t5\tinteger\n5\t6\t9\ntrue\n5\n");
}

TEST_CASE("meshes are files beside the scene or in the libraries; errors have both places", "[meshes]") {
  const MeshFolder f;
  f.write("scene/bad.obj", std::string(kSquare) + "f 1 2 9\n");
  f.write("outside.obj", std::string(kSquare) + "f 1 2 3\n");
  f.write("outside.bin", std::string(36, '\0'));
  f.write("scene/out.gltf", R"({"asset":{"version":"2.0"},"buffers":[{"uri":"../outside.bin","byteLength":36}]})");
  f.write("scene/far.gltf", R"({"asset":{"version":"2.0"},"buffers":[{"uri":"/etc/passwd","byteLength":36}]})");
  const auto error = [&](const std::string& call) { return run(f, "feder.load_mesh" + call, with_meshes()); };
  CHECK_THAT(error("'bad.obj'"), Catch::Contains("main.lua:2: feder.load_mesh: "));
  CHECK_THAT(error("'bad.obj'"), Catch::Contains("bad.obj:6: names vertex 9; there are 5 so far"));
  CHECK_THAT(error("'../outside.obj'"), Catch::Contains("expected the name of an .obj, .gltf or .glb file"));
  CHECK_THAT(error("'/etc/passwd.obj'"), Catch::Contains("expected the name of an .obj, .gltf or .glb file"));
  CHECK_THAT(error("'main.lua'"), Catch::Contains("got 'main.lua'"));
  CHECK_THAT(error("'none.glb'"), Catch::Contains("no file 'none.glb' beside the scene or in the libraries"));
  CHECK_THAT(error("('bad.obj', { wled = true })"), Catch::Contains("did you mean 'weld'?"));
  CHECK_THAT(error("'out.gltf'"), Catch::Contains("out.gltf: names the file '../outside.bin'"));
  CHECK_THAT(error("'far.gltf'"), Catch::Contains("far.gltf: names the file '/etc/passwd'"));
  CHECK_THAT(run(f, "feder.load_mesh 'bad.obj'", {}), Catch::Contains("this host reads no meshes"));
  lua::HostOptions options = with_meshes();
  options.library_roots = {f.path};
  CHECK(run(f, "print(#feder.load_mesh('outside.obj').triangles)", options) == "1\n");
}
