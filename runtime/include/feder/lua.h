// A script in its own Lua state: the C++ face of the Lua binding, used by the feder program, tests and embedders.
// Hides Lua completely. Errors are ScriptError with "file:line: message"; nothing a script does ends the process. One
// thread at a time, but for Script::interrupt; scripts share nothing.
#pragma once
#include <atomic>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "feder/object.h"
#include "feder/shape.h"
#include "feder/world.h"

namespace feder::lua {

// what() is "file:line: message" (one line), or the message alone when no position is known.
class ScriptError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Limits of HostOptions. A script cannot catch one: it is raised again after every pcall, xpcall and coroutine
// until the outermost call from the host has ended. The script can be called again.
enum class Limit { none, instructions, time, memory, output, interrupted };

// A call from the host ended at a limit.
class LimitError : public ScriptError {
 public:
  LimitError(const std::string& what, Limit limit) : ScriptError(what), limit_(limit) {}
  Limit limit() const { return limit_; }

 private:
  Limit limit_;
};

// HostOptions::set or ::world has a name or value that the script does not accept: a mistake of the host.
class OptionError : public ScriptError {
 public:
  using ScriptError::ScriptError;
};

// What a system adds to scripts.
struct Part;
std::span<const Part* const> parts();  // all of this build, in the library feder_lua

// How often each line with code has run, by file.
using LineCounts = std::map<int, std::uint64_t>;
using Coverage = std::map<std::string, LineCounts>;

// A file of triangles, for HostOptions::load_mesh.
struct MeshFile {
  std::string name;          // in messages
  std::string_view content;  // the bytes of the file
  bool weld = true;          // vertices at one place become one, those that no triangle has are left out
  // The bytes of another file that this one names, by the rules for the first; throws SceneError for one that may not
  // be read.
  std::function<std::string(const std::string& name)> read_beside = {};
};
struct TriangleMesh {
  std::vector<Vec3> vertices;            // m
  std::vector<std::uint32_t> triangles;  // three vertex numbers each, from 0
};

// A host that wants fewer systems names its own parts (feder/parts.h) and catalog where it makes the options, as
// HostOptions{.parts = mine, .systems = my_systems}, and links feder_lua_core and feder_lua_<module> alone. Both lists
// outlive the script.
struct HostOptions {
  std::span<const Part* const> parts = lua::parts();
  Catalog systems = catalog();
  std::vector<std::filesystem::path> library_roots =
      {};                                         // folders that `require` may read besides the scene's (scripts/)
  std::map<std::string, std::string> set = {};    // --set NAME=VALUE: values for feder.param
  std::map<std::string, std::string> world = {};  // --world KEY=VALUE: "dt", "substeps", "rigid.solver" ...
  bool has_seed = false;
  std::uint64_t seed = 1;
  std::function<void(std::string_view)> print = {};       // output of print(); stdout when empty
  std::size_t memory_limit = std::size_t(1) << 30;        // bytes of Lua memory; the size of a world is not limited
  std::uint64_t output_limit = std::uint64_t(256) << 20;  // bytes that print() may write in all; 0: none
  // Lua instructions per call from the host, four times as many in build(). Each handler, timer, task and force
  // function of a step is a call of its own; a plain script is one call. C functions are charged by the length of what
  // they work on, a caught error as 500, a step by a plain script as 100. What few instructions make slow (comparing
  // long strings, passing many arguments) ends when the call has taken 1 s and 100 ns per allowed instruction of
  // processor time in Lua, about ten times the usual. 0: no limit, no count (loops run up to twice as fast), and
  // interrupts are noticed between calls only.
  std::uint64_t instruction_limit = 100'000'000;
  // While true, scripts end as by Script::interrupt. For hosts that stop several scripts, or from a signal handler.
  const std::atomic<bool>* stop = nullptr;
  Executor executor = {};  // its threads help the worlds; without `call` each world makes its own workers
  // Makes the distance fields of scripts: make_sdf when empty. A host may keep them from run to run.
  MakeSdf make_field = {};
  // Called with each world as it is made, before anything is in it: to record it.
  std::function<void(World&)> made = {};
  // Reads YAML text as a value tree for feder.load; set by hosts that link bindings/yaml (see feder/yaml.h).
  // Pushes one Lua value on the stack of the lua_State* passed as void*; throws ScriptError.
  std::function<void(void* lua_state, const std::string& file, const std::string& text)> load_yaml = {};
  // Reads the triangles of a file for feder.load_mesh; set by hosts that link bindings/meshes (feder::meshes::read).
  // Throws SceneError "file:line: message".
  std::function<TriangleMesh(const MeshFile& file)> load_mesh = {};
  // Counts lines of Lua files that run, when not null: slow. It outlives the script.
  Coverage* coverage = nullptr;
};

// Camera of a scene: no part of the world, its hash or its snapshots.
// `camera = { target =, distance =, yaw =, pitch = }` of a scene; missing values are fitted to the scene.
struct SceneCamera {
  bool has_target = false, has_distance = false, has_yaw = false, has_pitch = false;
  double target[3] = {0, 0, 0};  // m
  double distance = 0;           // m
  double yaw = 0, pitch = 0;     // rad
};

// Appearance of the objects of a world.
struct Appearance {
  std::map<ObjectId, std::uint32_t> colors;              // 0xrrggbb; objects without one are not here
  std::map<ObjectId, float> transparencies;              // of bodies and fluids, 0..1; as above
  std::map<ObjectId, std::vector<std::uint32_t>> faces;  // of nets: three point numbers (from 0) per triangle
  std::uint64_t version = 0;                             // goes up when a colour of an older object changes
};

// Advice of a system on one of its objects before a world runs: feder.advise, `feder explain`.
struct Advice {
  using Fact = std::variant<std::int64_t, double, std::string>;  // a number may be infinite
  ObjectId object;
  std::string text;  // a sentence that names it
  std::vector<std::pair<const char*, Fact>> facts;
};

// A declared feder.param.
struct ParamInfo {
  std::string name, help, value, fallback;
  double min = 0, max = 0, step = 0;
  bool has_min = false, has_max = false, has_step = false;
  std::vector<std::string> choices;
};

// An error in a handler, timer, task or update(): reported once per file and line, counted after that.
struct HandlerError {
  std::string where;  // file:line
  std::string message;
  std::uint64_t count = 0;
  Limit limit = Limit::none;  // that ended it
  bool expectation = false;   // no error: a feder.expect outside check, which is among checks() too
};

// An expectation that does not hold. Texts that it does not have are empty.
struct CheckFailure {
  std::string where = {};  // file:line of the expect call
  std::string message = {};
  double time = 0;                         // s, simulated
  std::uint64_t step = 0;                  // steps done
  std::string object = {};                 // 'body "crate3"'
  std::string expected = {}, actual = {};  // with units
  std::string tolerance = {}, delta = {};  // between the two
  std::string call = {};                   // name of the function that was called, as the script has it
};
struct CheckResult {
  bool has_check = false;
  int passed = 0;
  std::vector<CheckFailure> failures;
  std::vector<CheckFailure> notes;  // that fail nothing
  Limit limit = Limit::none;        // that ended it
};

// A scene's golden = { ... }: what a run keeps to be compared, and how far a later one may be from it.
struct GoldenWish {
  bool declared = false;
  double every = 0.25;                                     // s between samples
  double position = 1e-3, rotation = 1e-2, energy = 1e-3;  // m, rad, share of the largest energy
  double relative = 0;                                     // of the way that an object has gone, on top of position
};

// Where an object is: a body's pose, or the centre of the points of a soft thing.
struct ObjectSample {
  std::string name;  // 'body "crate3"'
  std::size_t parts = 1;
  double position[3] = {0, 0, 0};     // m
  bool turns = false;                 // has it a rotation?
  double rotation[4] = {0, 0, 0, 1};  // x y z w
};

// Name -> values, in the order of the names.
using StudyAxes = std::vector<std::pair<std::string, std::vector<std::string>>>;

// Study declaration of a scene: study = { reference =, error =, axes =, ... }.
struct StudyDeclaration {
  enum class Reference { none, refined, stated, course };  // "self"; for the end; at any time

  bool declared = false;
  Reference reference = Reference::none;
  // functions that are there
  bool has_error = false, has_observe = false, has_measure = false, has_energy = false, has_event = false,
       has_constraint = false;
  std::string method, tolerance;     // the parameters that name the methods and take their tolerance; may be empty
  std::vector<std::string> methods;  // empty: all
  double seconds = 0;                // 0: the scene's
  StudyAxes axes;
  struct Ladder {
    std::vector<std::string> methods;  // that climb it; empty: all
    StudyAxes axes;
  };
  std::vector<Ladder> ladders;
  double length = 0, velocity = 0, energy = 0;  // scales; 0: not said
  std::string kind = "closed", source;          // of the reference
  double uncertainty = 1e-15, rounding = 1, resolution = 0;
  std::vector<std::string> conserves;
  bool interpolate = true;
  double sweeps = 1;
  int refined_substeps = 0;
};

// State that a study compares: three numbers per point, and orientations x y z w.
struct StudyState {
  std::vector<double> x, v, q;
};

// Time spent in a Lua handler, by file and line.
struct HandlerProfile {
  std::string where;
  std::uint64_t calls = 0, nanoseconds = 0;
};

// What a script passed to feder.plot under one name: the last values, oldest first.
struct PlotSeries {
  struct Point {
    double time = 0;  // s, simulated
    double value = 0;
  };
  std::string name;
  std::deque<Point> points;
};

class Script {
 public:
  explicit Script(HostOptions options);
  ~Script();
  Script(const Script&) = delete;
  Script& operator=(const Script&) = delete;

  // Runs a file (.lua, or .yaml/.yml when load_yaml is set) or a text. A scene is remembered; a plain script has run
  // from top to bottom when this returns.
  void load_file(const std::filesystem::path& file);
  void load_string(std::string_view text, const std::string& chunk_name);

  bool is_scene() const;
  std::string title() const;
  double seconds() const;  // of the scene; 0 when it has none
  double picture() const;  // thumbnail time, s; < 0 when the scene has none
  const SceneCamera& camera() const;
  std::vector<ParamInfo> params() const;

  // Scenes: makes the world from the scene's defaults, the overrides and the host's options, then calls build().
  void build();
  // The scene's world, or the last world a plain script made; null when there is none.
  World* world();
  // Colours and faces in that world; null without one.
  const Appearance* appearance() const;
  // One step: world.step(), then timers, events, tasks, update(). Handler errors are collected, not thrown.
  void step();
  // Studies: what the scene declares; its error now, in whatever unit it has (several numbers: their rms), against its
  // reference or, where that is "self", the numbers that the refined run left; its states ("observe", "reference") and
  // numbers ("measure", "energy", "event", "constraint"; lists are laid end to end), those of a reference at time t.
  // ScriptError where the scene has none or fails.
  const StudyDeclaration& study() const;
  double study_error(std::span<const double> refined = {});
  StudyState study_state(const char* name, double t = 0);
  std::vector<double> study_numbers(const char* name, double t = 0);
  // Runs the scene's check, which may step the world on. Expectations of all handlers and of plain scripts count too.
  CheckResult check();
  const CheckResult& checks() const;  // so far
  int random_tests() const;           // draws of the parameters that a test of the scene makes
  const GoldenWish& golden() const;
  std::vector<ObjectSample> sample();  // all objects that are somewhere, in the order of their kinds and slots
  const std::vector<HandlerError>& handler_errors() const;
  std::vector<HandlerProfile> handler_profile() const;

  // What feder.advise says of the world; empty without one.
  std::vector<Advice> advice();
  const std::vector<PlotSeries>& plots() const;
  // Files read so far, in the order they were first read: the scene, what it requires and loads. Complete after an
  // error too, the file with the mistake included.
  const std::vector<std::filesystem::path>& files() const;

  // Runs Lua text in the scene, between two steps. It sees the script's globals, `world`, `scene` and `feder`; what it
  // assigns is kept for the next text. An expression gives its value as text. ScriptError as ever.
  std::string run_string(std::string_view text, const std::string& chunk_name = "console");
  // From the next call on; takes effect only when the script was made with a limit.
  void set_instruction_limit(std::uint64_t per_call);
  // May be called from any thread and from a signal handler. What the script runs ends with Limit::interrupted within
  // some microseconds of Lua, and so does every later call; a running step of the world ends first. It is for good.
  void interrupt();

  // Called after every step of any world (plain scripts included): progress, recording.
  void on_step(std::function<void(World&)> callback);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace feder::lua

// In the library feder::meshes (find_package(feder COMPONENTS meshes)). Keeps nothing between calls; safe for any
// bytes.
namespace feder::meshes {

// All triangles of the file as one mesh, by the end of its name: .obj, .gltf, .glb. Polygons are cut into triangles;
// nodes of a glTF file place what they show. Lengths are taken as metres. Triangles with a vertex twice are left out.
// Throws SceneError that names the file and the line, or the part of a glTF file, and what is wrong with it: syntax,
// numbers that are not finite, vertices that do not exist, parts that lie outside of their buffers, no triangles.
lua::TriangleMesh read(const lua::MeshFile& file);

}  // namespace feder::meshes
