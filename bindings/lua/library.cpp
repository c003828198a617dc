// Files of scripts: modules (require), YAML (feder.load) and meshes (feder.load_mesh), from the library folders and the
// folder of the scene.
#include "lua/library.h"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <system_error>

#include "lua/coverage.h"
#include "lua/options.h"
#include "lua/stack.h"

namespace feder::lua {
namespace {

namespace fs = std::filesystem;

// lower_case words with dots between: no "..", no slash, nothing hidden.
bool is_module_name(const std::string& name) {
  const auto allowed = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '.'; };
  return !name.empty() && name.size() <= 200 && std::ranges::all_of(name, allowed) && name.front() != '.' &&
         name.back() != '.' && name.find("..") == std::string::npos;
}

// The file `name` in `folder`, when it is a regular file that really lies inside.
fs::path inside(const fs::path& folder, const fs::path& name) {
  std::error_code error;
  const fs::path root = fs::canonical(folder.empty() ? fs::path(".") : folder, error);
  if (error) return {};
  const fs::path real = fs::canonical(root / name, error);
  if (error || !fs::is_regular_file(real, error)) return {};
  const auto end = std::mismatch(root.begin(), root.end(), real.begin(), real.end()).first;
  return end == root.end() ? folder / name : fs::path();
}

void run_module(lua_State* L, const std::string& name, const fs::path& file) {
  State& s = state(L);
  record_file(s, file);
  const std::string text = read_text(file);
  if (luaL_loadbufferx(L, text.data(), text.size(), ("@" + chunk_name(file)).c_str(), "t") != LUA_OK) lua_error(L);
  cover_chunk(L, file);
  struct Loading {
    State& s;
    ~Loading() { s.loading.pop_back(); }
  };
  s.loading.push_back(name);
  const Loading loading{s};
  lua_pushstring(L, name.c_str());
  lua_call(L, 1, 1);
}

// "materials.yaml", "sub/materials.yml": relative, no "..", with one of the extensions if there are any.
bool is_data_name(const std::string& name, std::initializer_list<const char*> extensions) {
  if (name.empty() || name.size() > 200 || name[0] == '/' || name.find("..") != std::string::npos) return false;
  const bool plain = std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '-' || c == '.' || c == '/';
  });
  const fs::path extension = fs::path(name).extension();
  return plain && (extensions.size() == 0 || std::ranges::find(extensions, extension) != extensions.end());
}

struct MeshReading {
  bool weld = true;
};

constexpr Option<MeshReading> kLoadMesh[] = {
    field<&MeshReading::weld>("weld"),
};

// The folder that has the file `name`: the scene's, or a library; empty when none has.
fs::path folder_with(const State& s, const std::string& name) {
  if (!s.folder.empty() && !inside(s.folder, name).empty()) return s.folder;
  for (const fs::path& root : s.options.library_roots)
    if (!inside(root, name).empty()) return root;
  return {};
}

// A file that a mesh names: of the mesh's folder or one below, and of the same root.
std::string read_beside(State& s, const fs::path& root, const fs::path& folder, const std::string& name) {
  if (!is_data_name(name, {}))
    throw SceneError("names the file '" + name + "', which is not plainly one beside it or in a folder below");
  const fs::path file = inside(root, folder / name);
  if (file.empty()) throw SceneError("no file '" + name + "' beside it");
  record_file(s, file);
  return read_text(file);
}

void push_numbers(lua_State* L, std::initializer_list<double> numbers, bool whole) {
  lua_createtable(L, 3, 0);
  int k = 0;
  for (const double x : numbers) {
    whole ? lua_pushinteger(L, static_cast<lua_Integer>(x)) : lua_pushnumber(L, x);
    lua_rawseti(L, -2, ++k);
  }
}

void push_mesh(lua_State* L, const TriangleMesh& mesh) {
  charge(L, 4 * (mesh.vertices.size() + mesh.triangles.size() / 3));
  lua_createtable(L, 0, 2);
  lua_createtable(L, static_cast<int>(mesh.vertices.size()), 0);
  lua_Integer n = 0;
  for (const Vec3& v : mesh.vertices) {
    push_numbers(L, {double(v[0]), double(v[1]), double(v[2])}, false);
    lua_rawseti(L, -2, ++n);
  }
  lua_setfield(L, -2, "vertices");
  lua_createtable(L, static_cast<int>(mesh.triangles.size() / 3), 0);
  for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
    push_numbers(L, {mesh.triangles[t] + 1.0, mesh.triangles[t + 1] + 1.0, mesh.triangles[t + 2] + 1.0}, true);
    lua_rawseti(L, -2, static_cast<lua_Integer>(t / 3 + 1));
  }
  lua_setfield(L, -2, "triangles");
}

}  // namespace

bool is_left_out(const std::string& name) {
  constexpr std::string_view own = "feder.", without = "," FEDER_WITHOUT ",view,study,";  // the last two: to come
  if (name.rfind(own, 0) != 0) return false;
  return without.find("," + name.substr(own.size()) + ",") != std::string_view::npos;
}

std::string read_text(const fs::path& file) {
  std::error_code error;
  const auto size = fs::file_size(file, error);
  if (error) throw SceneError(file.string() + ": cannot be read: " + error.message());
  if (size > (std::uintmax_t(64) << 20)) throw SceneError(file.string() + ": larger than 64 MB");
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) throw SceneError(file.string() + ": cannot be read");
  return text.str();
}

void record_file(State& s, const fs::path& file) {
  std::error_code error;
  fs::path full = fs::absolute(file, error).lexically_normal();
  if (std::find(s.files.begin(), s.files.end(), full) == s.files.end()) s.files.push_back(std::move(full));
}

std::string chunk_name(const fs::path& file) {
  std::string name = file.lexically_normal().generic_string();
  // Lua cuts names of 60 characters and more in its own messages: leave whole folders out instead
  while (name.size() > 57) {
    const std::size_t slash = name.find('/', 1);
    if (slash == std::string::npos) break;
    name.erase(0, slash + 1);
  }
  return name;
}

int lua_require(lua_State* L) {
  State& s = state(L);
  if (lua_type(L, 1) != LUA_TSTRING) fail(L, "require: expected the name of a module, got " + describe(L, 1));
  const std::string name(text_at(L, 1));
  // a module that has been loaded is given again
  lua_rawgeti(L, LUA_REGISTRYINDEX, s.modules_ref);
  lua_pushvalue(L, 1);
  if (lua_rawget(L, -2) != LUA_TNIL) return 1;
  if (is_left_out(name)) fail(L, "require: this build leaves out the module '" + name + "'");
  if (!is_module_name(name))
    fail(L, "require: expected a name of lower-case words with dots between, got " + describe(L, 1));
  if (std::find(s.loading.begin(), s.loading.end(), name) != s.loading.end()) {
    std::string chain;
    for (const std::string& m : s.loading) chain += m + " -> ";
    fail(L, "require: modules need each other in a circle: " + chain + name);
  }
  // its file: the libraries first, then the folder of the scene
  std::string relative = name;
  std::replace(relative.begin(), relative.end(), '.', '/');
  relative += ".lua";
  fs::path file;
  for (const fs::path& root : s.options.library_roots)
    if (file.empty()) file = inside(root, relative);
  if (file.empty() && !s.folder.empty()) file = inside(s.folder, relative);
  if (file.empty()) {
    const std::string where = s.folder.empty() ? "" : " and beside the scene";
    fail(L, "require: no module '" + name + "': no file " + relative + " in the " +
                std::to_string(s.options.library_roots.size()) + " library folders" + where);
  }
  // what it returns is kept under its name; true for nothing
  run_module(L, name, file);
  if (lua_isnil(L, -1)) lua_pop(L, 1), lua_pushboolean(L, 1);
  lua_rawgeti(L, LUA_REGISTRYINDEX, s.modules_ref);
  lua_pushvalue(L, -2);
  lua_setfield(L, -2, name.c_str());
  lua_pop(L, 1);
  return 1;
}

int feder_load(lua_State* L) {
  State& s = state(L);
  const std::string name = check_text(L, 1, function_name(L));
  if (!is_data_name(name, {".yaml", ".yml"}))
    fail_here(L, "expected the name of a .yaml file beside the scene or in a library, got " + describe(L, 1));
  if (!s.options.load_yaml) fail_here(L, "this host reads no YAML");
  fs::path file;
  if (!s.folder.empty()) file = inside(s.folder, name);
  for (const fs::path& root : s.options.library_roots)
    for (const fs::path& folder :
         {root, root / "materials", root / "scenes" / "materials", root / ".." / "scenes" / "materials"})
      if (file.empty()) file = inside(folder, name);
  if (file.empty()) fail_here(L, "no file '" + name + "' beside the scene or in the libraries");
  record_file(s, file);
  push_yaml(L, chunk_name(file), read_text(file));
  return 1;
}

int feder_load_mesh(lua_State* L) {
  State& s = state(L);
  const std::string name = check_text(L, 1, function_name(L));
  if (!is_data_name(name, {".obj", ".gltf", ".glb"}))
    fail_here(
        L, "expected the name of an .obj, .gltf or .glb file beside the scene or in a library, got " + describe(L, 1));
  MeshReading reading;
  if (!lua_isnoneornil(L, 2)) Options(L, 2, function_name(L)).read(kLoadMesh, reading);
  if (!s.options.load_mesh)
    fail_here(L,
              is_left_out("feder.meshes") ? "this build leaves out the module 'meshes'" : "this host reads no meshes");
  const fs::path root = folder_with(s, name);
  if (root.empty()) fail_here(L, "no file '" + name + "' beside the scene or in the libraries");
  const fs::path file = inside(root, name);
  record_file(s, file);
  TriangleMesh mesh;
  std::string error;
  s.outside_lua([&] {
    try {
      const std::string content = read_text(file);
      mesh = s.options.load_mesh({chunk_name(file), content, reading.weld, [&](const std::string& beside) {
                                    return read_beside(s, root, fs::path(name).parent_path(), beside);
                                  }});
    } catch (const SceneError& e) {
      error = e.what();
    }
  });
  if (!error.empty()) fail_here(L, error);
  push_mesh(L, mesh);
  return 1;
}

std::vector<OptionInfo> load_mesh_rows() { return describe_rows(kLoadMesh); }

void push_yaml(lua_State* L, const std::string& file, const std::string& text) {
  std::string error;
  try {
    state(L).options.load_yaml(L, file, text);
    return;
  } catch (const ScriptError& e) {
    error = e.what();
  }
  raise_error(L, error);
}

}  // namespace feder::lua
