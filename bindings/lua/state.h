// One Lua state and what the binding keeps beside it: limits, classes, worlds, errors. Everything of the binding finds
// it through state(L). Lua is linked as C++, so an error unwinds destructors; SceneError and bad_alloc become Lua
// errors in guard<>, never anywhere else.
#pragma once
#include <lauxlib.h>
#include <lua.h>
#include <lualib.h>

#include <atomic>
#include <map>
#include <memory>
#include <new>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/rng.h"
#include "feder/error.h"
#include "feder/lua.h"
#include "feder/params.h"
#include "feder/profile.h"

namespace feder::lua {

struct WorldRecord;
struct ObjectClass;
struct Task;

// Classes of userdata: the binding's own, then those of the host's parts.
// `object`: one of a system that has no part here.
enum class Class : int { world, object, force, shape, buffer, connection, task, event, parts };
inline constexpr int kOwnClasses = static_cast<int>(Class::parts);

// A row of the API: what a script sees, and what `feder doc` prints.
struct Method {
  const char* name;
  lua_CFunction fn;
  const char* signature;
  const char* doc;
  std::vector<OptionInfo> (*options)() = nullptr;  // of its options table
};

// What is being run for the host. Declaring parameters is for `loading`; stepping by hand is for plain scripts.
enum class Phase { loading, idle, building, running, checking };

// Where an error came from and what it said.
struct Failure {
  std::string where;    // file:line, may be empty
  std::string message;  // one line
  Limit limit = Limit::none;
  bool expectation = false;  // no error: an expectation that does not hold
  std::string text() const { return where.empty() ? message : where + ": " + message; }
};

// The scene of the state, when it has one.
struct SceneState {
  int table = LUA_NOREF;   // what feder.scene returned
  int passed = LUA_NOREF;  // the copy of it that build, update and check see
  std::string title;
  double seconds = 0;
  double picture = -1;  // s; < 0: not said
  SceneCamera camera;
  std::string where;  // file:line of feder.scene
  bool has_update = false, has_check = false;
  int random = 0;  // draws of the parameters that a test makes
  GoldenWish golden;
  StudyDeclaration study;
  int last = LUA_NOREF;  // of feder.scene, while the file loads
};

struct State {
  static constexpr std::uint64_t kBuildFactor = 4;

  explicit State(HostOptions o);
  ~State();
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  // Calls the function below `args` arguments on the stack. False: the error is in `failure`, the stack holds no
  // results. A limit that is reached inside an outer call is raised again, so nothing can swallow it.
  // An `outer` call is the frame around a whole step: the budget is that of each call inside it.
  bool call(lua_State* on, int args, int results, Failure& failure, bool outer = false);
  // The same for a coroutine with `args` arguments on its stack; it may yield. True: ended or yielded.
  bool resume(lua_State* thread, lua_State* from, int args, bool& yielded, Failure& failure);
  // The error of a call that ended with `status`, on top of the stack; a limit of an outer call is raised again.
  void take_failure(lua_State* on, lua_State* outer, int status, Failure& failure);
  void begin_call();
  // An error in a handler, timer, task or update(): counted by location.
  void report(const Failure& failure);
  void print(std::string_view text) const;
  // Takes `units` instructions off the budget of the outermost call; raises a limit that is reached, or was.
  void spend(lua_State* on, std::uint64_t units);
  // Raises the limit now and after every protected call.
  [[noreturn]] void trip(lua_State* on, Limit limit);
  [[noreturn]] void raise_limit(lua_State* on);
  // After protected code with this status: a limit reached meanwhile is raised again, lack of memory becomes one.
  void check_limits(lua_State* on, int status);
  std::string limit_text() const;
  std::uint64_t allowed_instructions() const;  // per call; build() may take kBuildFactor times as many
  bool stopped() const { return interrupted || (options.stop && *options.stop); }
  // Processor time of the world's own work, which no limit of Lua covers.
  template <class F>
  void outside_lua(F&& work) {
    const double before = lua_start > 0 && depth > 0 ? thread_seconds() : 0;
    work();
    if (before > 0) lua_start += thread_seconds() - before;
  }
  static double thread_seconds();  // processor time of this thread
  // The slot of handler_profile for the function at `index`.
  std::size_t profile_slot(lua_State* on, int index);
  // Runs a call of that function, f() -> did it end well, and counts it.
  template <class F>
  bool profiled(std::size_t slot, F&& f) {
    const std::uint64_t start = clock_nanoseconds();
    const bool good = f();
    profile[slot].calls += 1;
    profile[slot].nanoseconds += clock_nanoseconds() - start;
    return good;
  }
  // Calls a handler, the function below `args` arguments on the stack; an error in it is reported.
  void call_handler(lua_State* on, std::size_t slot, int args);
  WorldRecord* current() const;  // the scene's world, or the last of a plain script; null before
  Rng& random();                 // of the current world; before the first world, the state's own

  HostOptions options;
  std::vector<const ObjectClass*> object_classes;  // from Class::parts on
  lua_State* L = nullptr;
  std::size_t memory_used = 0;        // bytes
  std::uint64_t budget = 0;           // instructions left of the outermost call
  Limit limit = Limit::none;          // reached: every hook raises until the outermost call has ended
  std::string limit_location;         // file:line where it was reached
  std::string memory_location;        // where the allocator last refused
  double lua_start = 0;               // s of thread_seconds at the first hook of the outermost call; 0: none yet
  std::uint64_t last_time_check = 0;  // ns, wall clock when thread_seconds was last read
  std::uint64_t printed = 0;          // bytes
  std::atomic<bool> interrupted = false;
  bool wrong_option = false;   // the error on its way is one of HostOptions::set or ::world
  int depth = 0;               // calls from the host into Lua, nested
  std::vector<int> class_ref;  // metatables, by class
  int worlds_ref = 0;          // weak table: world id -> world userdata
  int modules_ref = 0;         // name -> value, of require
  int ids_ref = 0;             // weak table: value -> number shown by tostring
  lua_Integer next_id = 0;
  int last_world_ref = LUA_NOREF;  // keeps the last world (or the scene's) alive
  std::uint32_t last_world = 0xffffffffu;
  std::vector<std::unique_ptr<WorldRecord>> worlds;
  Rng rng;
  SceneState scene;
  Phase phase = Phase::loading;
  bool is_scene = false;
  std::filesystem::path folder;       // of the scene file; empty for strings
  std::vector<std::string> loading;   // modules being required, for the cycle message
  WorldRecord* task_world = nullptr;  // of the task that runs now
  Task* task = nullptr;
  lua_State* task_thread = nullptr;
  std::vector<ParamInfo> params;
  int params_ref = 0;  // name -> value
  std::vector<HandlerError> errors;
  CheckResult checks;                      // of all expectations so far
  int expect_ref = LUA_NOREF;              // feder.expect
  std::uint64_t handler_instructions = 0;  // of a scene's steps, or of a plain script
  std::vector<HandlerProfile> profile;
  std::function<void(World&)> on_step;
  std::vector<PlotSeries> plots;
  std::vector<std::filesystem::path> files;                       // read so far
  std::map<std::string, std::string, std::less<>> covered_files;  // chunk name -> path
  int console_ref = LUA_NOREF;                                    // environment of Script::run_string
};

const char* class_name(const State& s, Class c);
// The class that parts or the binding give objects of the world under that name; Class::object when there is none.
Class object_class(const State& s, std::string_view name);
// Null for the binding's own.
const ObjectClass* class_row(const State& s, Class c);

inline State& state(lua_State* L) { return **static_cast<State**>(lua_getextraspace(L)); }

// "file:line" of the innermost Lua function at or above `level`; "" when there is none.
std::string location(lua_State* L, int level = 0);
// The same with the file's name alone: what a destroyed object remembers.
std::string short_location(lua_State* L);
// Raises the message as it is.
[[noreturn]] void raise_error(lua_State* L, const std::string& message);
// Raises "file:line: message".
[[noreturn]] void fail(lua_State* L, const std::string& message);
// Raises "file:line: function: message", with the name of the running API function.
[[noreturn]] void fail_here(lua_State* L, const std::string& message);
// The API name of the running C function ("body:position").
const char* function_name(lua_State* L);
// A value for messages: -5, 'text', a table, body "crate3" ...
std::string describe(lua_State* L, int index);
// Splits "file:line: message"; where stays empty when the text has no location.
Failure split_location(std::string_view text);
// Takes `units` instructions off the budget, for C functions that work long.
void charge(lua_State* L, std::uint64_t units);
std::string join(std::span<const std::string> words);
// "; did you mean 'box'?" when one of the known is near, else "".
std::string did_you_mean(std::string_view word, const std::vector<std::string>& known);
// The same, but "; known: a, b" when none is near.
std::string did_you_mean_or(std::string_view word, const std::vector<std::string>& known);

// A SceneError of the runtime as the error of the running API function: "density: ..." thrown under world:body becomes
// "world:body.density: ...".
[[noreturn]] void relay(lua_State* L, const std::string& what);

// Turns C++ errors of an API function into Lua errors.
template <int (*F)(lua_State*)>
int guard(lua_State* L) {
  std::string message;
  try {
    return F(L);
  } catch (const std::bad_alloc&) {
    message = "not enough memory";
  } catch (const std::exception& e) {
    message = e.what();
  }
  relay(L, message);
}

// Fills the table on top of the stack: each function gets upvalues (metatable of its class or nil, qualified name,
// row). The rows outlive the state.
void add_methods(lua_State* L, std::span<const Method> rows, const std::string& prefix, int metatable);
// Makes the metatable of a class from its methods; leaves it on the stack for metamethods.
// "method body:position() -> x, y, z" of a function at `index` that add_methods made; "" for others.
std::string method_text(lua_State* L, int index);
void make_class(lua_State* L, Class c, const std::vector<std::span<const Method>>& method_lists);
void push_class(lua_State* L, Class c);

// The block of the userdata at `index` when it is of the class in upvalue 1 (methods) or `c`; else null.
void* self_block(lua_State* L);
void* test_class(lua_State* L, int index, Class c);
// A function is expected there.
void check_function(lua_State* L, int index);
[[noreturn]] void wrong_self(lua_State* L, const char* expected);

}  // namespace feder::lua
