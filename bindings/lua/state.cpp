// The Lua state: memory and instruction limits, calls and their errors, classes of userdata.
#include "lua/state.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

#include "feder/params.h"
#include "feder/shape.h"
#include "lua/coverage.h"
#include "lua/records.h"
#include "lua/sandbox.h"
#include "lua/stack.h"

namespace feder::lua {
namespace {

constexpr int kHookSlice = 1000;                 // instructions between two checks of the limits
constexpr double kSecondsPerInstruction = 1e-7;  // of processor time, about ten times the usual
constexpr std::size_t kLongBlock = 512;          // bytes; making and copying longer ones is charged
constexpr int kBytesPerUnit = 16;
const char kLimitSentinel = 0;  // the error value on the way out of a limit

void* allocate(void* self, void* block, std::size_t old_size, std::size_t new_size) {
  State& s = *static_cast<State*>(self);
  if (!block) old_size = 0;
  if (new_size == 0) {
    std::free(block);
    s.memory_used -= old_size;
    return nullptr;
  }
  if (new_size > old_size && s.memory_used + (new_size - old_size) > s.options.memory_limit) {
    // Lua collects garbage and asks again; only the second refusal is an error, without a location of its own
    if (s.L) s.memory_location = location(s.L);
    return nullptr;
  }
  // concatenation, buffers and growing tables are long work of one instruction; the next hook sees the charge
  if (new_size > old_size && new_size >= kLongBlock)
    s.budget -= std::min<std::uint64_t>(s.budget, new_size / kBytesPerUnit);
  void* moved = std::realloc(block, new_size);
  if (moved) s.memory_used += new_size - old_size;
  return moved;
}

int panic(lua_State* L) {
  std::fprintf(stderr, "feder: unprotected error in Lua: %s\n", lua_tostring(L, -1));
  return 0;
}

void limit_hook(lua_State* L, lua_Debug* at) {
  State& s = state(L);
  if (at->event == LUA_HOOKLINE) return cover_line(L, at);
  s.spend(L, std::min<std::uint64_t>(kHookSlice, s.options.instruction_limit));
  const std::uint64_t now = clock_nanoseconds();
  if (s.lua_start > 0 && now - s.last_time_check < 100'000'000) return;
  const double time = State::thread_seconds();
  if (s.lua_start <= 0) s.lua_start = time;
  s.last_time_check = now;
  if (time - s.lua_start > 1 + kSecondsPerInstruction * static_cast<double>(s.allowed_instructions()))
    s.trip(L, Limit::time);
}

// What an error value says: its text, or what its __tostring answers.
std::string error_text(lua_State* L, int index) {
  if (lua_type(L, index) == LUA_TSTRING || lua_type(L, index) == LUA_TNUMBER) {
    lua_pushvalue(L, index);
    std::string copy(text_at(L, -1));
    lua_pop(L, 1);
    return copy;
  }
  const int top = lua_gettop(L);
  std::string text;
  if (luaL_getmetafield(L, index, "__tostring") != LUA_TNIL) {
    lua_pushvalue(L, index);
    if (lua_pcall(L, 1, 1, 0) == LUA_OK && lua_type(L, -1) == LUA_TSTRING) text = lua_tostring(L, -1);
  }
  lua_settop(L, top);
  return text.empty() ? "error object is " + describe(L, index) : text;
}

// Message handler of State::call: the error becomes text with a location while the stack still stands.
int on_error(lua_State* L) {
  if (state(L).limit != Limit::none) return 1;
  std::string text = error_text(L, 1);
  if (split_location(text).where.empty()) {
    const std::string at = location(L, 1);
    if (!at.empty()) text = at + ": " + text;
  }
  lua_pushlstring(L, text.data(), text.size());
  return 1;
}

// Errors are one line without control bytes, of bounded length.
std::string one_line(std::string text) {
  if (text.size() > 4000) text.resize(4000);
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 32 || c == 127) c = ' ';
  return text;
}

int unknown_member(lua_State* L) {  // upvalues: class name, methods
  const char* name = lua_tostring(L, lua_upvalueindex(1));
  constexpr std::string_view without = "," FEDER_WITHOUT ",";
  if (lua_type(L, 2) == LUA_TSTRING && without.find("," + std::string(lua_tostring(L, 2)) + ",") != without.npos)
    fail(L, std::string(name) + ":" + lua_tostring(L, 2) + ": this build leaves out the module '" + lua_tostring(L, 2) +
                "'");
  std::vector<std::string> known;
  lua_pushnil(L);
  while (lua_next(L, lua_upvalueindex(2))) {
    known.emplace_back(lua_tostring(L, -2));
    lua_pop(L, 1);
  }
  std::sort(known.begin(), known.end());
  if (lua_type(L, 2) != LUA_TSTRING) fail(L, std::string("a ") + name + " has no member " + describe(L, 2));
  const std::string asked = lua_tostring(L, 2);
  fail(L, std::string("a ") + name + " has no method '" + asked + "'" + did_you_mean(asked, known));
}

int no_fields(lua_State* L) {
  fail(L, std::string("a ") + lua_tostring(L, lua_upvalueindex(1)) +
              " keeps no fields of a script; use a table keyed by it");
}

}  // namespace

const ObjectClass* class_row(const State& s, Class c) {
  return c < Class::parts ? nullptr : s.object_classes[static_cast<std::size_t>(static_cast<int>(c) - kOwnClasses)];
}

const char* class_name(const State& s, Class c) {
  static const char* const names[kOwnClasses] = {"world",  "object",     "force", "shape",
                                                 "buffer", "connection", "task",  "event"};
  const ObjectClass* row = class_row(s, c);
  return row ? row->name : names[static_cast<int>(c)];
}

Class object_class(const State& s, std::string_view name) {
  if (name == kForceKind.text()) return Class::force;
  for (std::size_t i = 0; i < s.object_classes.size(); ++i)
    if (name == s.object_classes[i]->name) return static_cast<Class>(kOwnClasses + static_cast<int>(i));
  return Class::object;
}

State::State(HostOptions o) : options(std::move(o)), rng(options.has_seed ? options.seed : 1) {
  for (const Part* part : options.parts)
    for (const ObjectClass& c : part->classes) object_classes.push_back(&c);
  class_ref.resize(static_cast<std::size_t>(kOwnClasses) + object_classes.size());
  L = lua_newstate(&allocate, this);
  if (!L) throw ScriptError("not enough memory for a Lua state");
  *static_cast<State**>(lua_getextraspace(L)) = this;
  lua_atpanic(L, &panic);
  const int mask = (options.instruction_limit > 0 ? LUA_MASKCOUNT : 0) | (options.coverage ? LUA_MASKLINE : 0);
  if (mask != 0)
    lua_sethook(L, &limit_hook, mask, static_cast<int>(std::min<std::uint64_t>(kHookSlice, options.instruction_limit)));
  lua_pushcfunction(L, &open_sandbox);
  Failure failure;
  if (!call(L, 0, 0, failure)) {
    lua_close(L);
    throw ScriptError(failure.text());
  }
}

State::~State() {
  lua_close(L);
  worlds.clear();
}

std::uint64_t State::allowed_instructions() const {
  const std::uint64_t n = options.instruction_limit, most = ~std::uint64_t(0) / kBuildFactor;
  return phase == Phase::building && n < most ? n * kBuildFactor : n;
}

void State::begin_call() {
  budget = allowed_instructions();
  limit = Limit::none;
  limit_location.clear();
  lua_start = 0;
}

bool State::call(lua_State* on, int args, int results, Failure& failure, bool outer) {
  const int base = lua_gettop(on) - args;
  if (depth == 0) {
    begin_call();
    if (stopped() && ids_ref != 0) {  // the libraries are opened in any case
      lua_settop(on, base - 1);
      failure = {"", "interrupted", Limit::interrupted};
      return false;
    }
  }
  depth += !outer;
  lua_pushcfunction(on, &on_error);
  lua_insert(on, base);
  const int status = lua_pcall(on, args, results, base);
  depth -= !outer;
  lua_remove(on, base);
  if (status == LUA_OK && limit == Limit::none) return true;
  if (status == LUA_OK) lua_pop(on, results), lua_pushnil(on);
  take_failure(on, on, status, failure);
  lua_pop(on, 1);
  limit = Limit::none;
  return false;
}

bool State::resume(lua_State* thread, lua_State* from, int args, bool& yielded, Failure& failure) {
  if (depth == 0) begin_call();
  ++depth;
  int results = 0;
  const int status = lua_resume(thread, from, args, &results);
  --depth;
  yielded = status == LUA_YIELD;
  if ((status == LUA_OK || yielded) && limit == Limit::none) {
    lua_pop(thread, results);
    return true;
  }
  if (status == LUA_ERRMEM) memory_location = location(thread);
  if (status == LUA_OK || yielded) lua_pushnil(thread);
  const std::string at = location(thread);
  take_failure(thread, nullptr, status, failure);
  if (failure.where.empty()) failure.where = at;
  lua_resetthread(thread);
  if (limit != Limit::none && depth > 0) raise_limit(from);
  limit = Limit::none;
  return false;
}

void State::take_failure(lua_State* on, lua_State* outer, int status, Failure& failure) {
  if (status == LUA_ERRMEM && limit == Limit::none) limit = Limit::memory, limit_location = memory_location;
  if (limit == Limit::none) {
    failure = split_location(one_line(error_text(on, -1)));
    return;
  }
  failure = {limit_location, limit_text(), limit};
  if (depth > 0 && outer) raise_limit(outer);
}

void State::spend(lua_State* on, std::uint64_t units) {
  if (limit != Limit::none) raise_limit(on);
  if (stopped()) trip(on, Limit::interrupted);
  if (phase == Phase::running || phase == Phase::loading) handler_instructions += units;
  if (options.instruction_limit == 0) return;
  if (budget < units) trip(on, Limit::instructions);
  budget -= units;
}

void State::trip(lua_State* on, Limit reached) {
  limit = reached;
  limit_location = location(on);
  raise_limit(on);
}

void State::raise_limit(lua_State* on) {
  lua_pushlightuserdata(on, const_cast<char*>(&kLimitSentinel));
  lua_error(on);
  std::abort();  // lua_error does not return
}

void State::check_limits(lua_State* on, int status) {
  if (status == LUA_ERRMEM && limit == Limit::none) limit = Limit::memory, limit_location = memory_location;
  if (limit != Limit::none) raise_limit(on);
}

std::string State::limit_text() const {
  switch (limit) {
    case Limit::instructions: return "instruction limit of " + std::to_string(allowed_instructions()) + " reached";
    case Limit::time: return "time limit reached: few instructions that take long";
    case Limit::memory: return "not enough memory: the limit is " + std::to_string(options.memory_limit) + " bytes";
    case Limit::output:
      return "output limit reached: print wrote more than " + std::to_string(options.output_limit) + " bytes";
    case Limit::interrupted: return "interrupted";
    case Limit::none: break;
  }
  return {};
}

double State::thread_seconds() {
  timespec t = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

void State::report(const Failure& failure) {
  // without a location, the message tells errors apart
  for (HandlerError& e : errors) {
    if (e.where == failure.where && (!e.where.empty() || e.message == failure.message) &&
        e.expectation == failure.expectation) {
      ++e.count;
      return;
    }
  }
  errors.push_back({failure.where, failure.message, 1, failure.limit, failure.expectation});
}

void State::print(std::string_view text) const {
  if (options.print) {
    options.print(text);
    return;
  }
  std::fwrite(text.data(), 1, text.size(), stdout);
  std::fflush(stdout);
}

std::size_t State::profile_slot(lua_State* on, int index) {
  lua_pushvalue(on, index);
  lua_Debug ar;
  lua_getinfo(on, ">S", &ar);
  const std::string source = ar.source[0] == '@' || ar.source[0] == '=' ? ar.source + 1 : ar.short_src;
  const std::string where = source + ":" + std::to_string(ar.linedefined);
  for (std::size_t i = 0; i < profile.size(); ++i)
    if (profile[i].where == where) return i;
  profile.push_back({where, 0, 0});
  return profile.size() - 1;
}

void State::call_handler(lua_State* on, std::size_t slot, int args) {
  Failure failure;
  if (!profiled(slot, [&] { return call(on, args, 0, failure); })) report(failure);
}

WorldRecord* State::current() const { return last_world < worlds.size() ? worlds[last_world].get() : nullptr; }

Rng& State::random() { return current() && current()->world ? current()->world->rng() : rng; }

std::string location(lua_State* L, int level) {
  lua_Debug ar;
  for (; lua_getstack(L, level, &ar); ++level) {
    lua_getinfo(L, "Sl", &ar);
    if (ar.currentline <= 0) continue;
    const std::string source = ar.source[0] == '@' || ar.source[0] == '=' ? ar.source + 1 : ar.short_src;
    return source + ":" + std::to_string(ar.currentline);
  }
  return {};
}

std::string short_location(lua_State* L) {
  const std::string at = location(L);
  const std::size_t slash = at.find_last_of('/');
  return slash == std::string::npos ? at : at.substr(slash + 1);
}

void raise_error(lua_State* L, const std::string& message) {
  lua_pushstring(L, message.c_str());
  lua_error(L);
  std::abort();  // lua_error does not return
}

void fail(lua_State* L, const std::string& message) {
  const std::string at = location(L);
  raise_error(L, at.empty() ? message : at + ": " + message);
}

void fail_here(lua_State* L, const std::string& message) {
  const char* name = function_name(L);
  fail(L, *name ? std::string(name) + ": " + message : message);
}

void relay(lua_State* L, const std::string& what) {
  const std::string name = function_name(L);
  if (name.empty()) fail(L, what);
  const std::size_t dot = name.find_last_of(":.");
  const std::string last = dot == std::string::npos ? name : name.substr(dot + 1);
  if (what.rfind(last + ":", 0) == 0 || what.rfind(last + ".", 0) == 0) fail(L, name + what.substr(last.size()));
  const bool noun = last == "world" || object_class(state(L), last) != Class::object;  // it makes one of these
  std::size_t word = 0;
  while (word < what.size() &&
         (std::isalnum(static_cast<unsigned char>(what[word])) || what[word] == '_' || what[word] == '.'))
    ++word;
  const bool option = noun && word > 0 && what.compare(word, 2, ": ") == 0;
  fail(L, name + (option ? "." : ": ") + what);
}

const char* function_name(lua_State* L) {
  lua_Debug ar;
  if (!lua_getstack(L, 0, &ar)) return "";
  lua_getinfo(L, "S", &ar);
  if (std::strcmp(ar.what, "C") != 0 || lua_type(L, lua_upvalueindex(2)) != LUA_TSTRING) return "";
  return lua_tostring(L, lua_upvalueindex(2));
}

std::string describe(lua_State* L, int index) {
  switch (lua_type(L, index)) {
    case LUA_TNONE:
    case LUA_TNIL: return "nil";
    case LUA_TBOOLEAN: return lua_toboolean(L, index) ? "true" : "false";
    case LUA_TNUMBER: return print_number(lua_tonumber(L, index));
    case LUA_TSTRING: {
      const std::string_view text = text_at(L, index);
      return "'" + std::string(text.substr(0, 40)) + (text.size() > 40 ? "...'" : "'");
    }
    case LUA_TTABLE: return "a table";
    case LUA_TFUNCTION: return "a function";
    case LUA_TTHREAD: return "a coroutine";
    default: break;
  }
  for (int c = 0; c < static_cast<int>(state(L).class_ref.size()); ++c)
    if (test_class(L, index, static_cast<Class>(c))) return describe_object(L, index, static_cast<Class>(c));
  return "a userdata";
}

Failure split_location(std::string_view text) {
  // the first ":<digits>: " ends a location
  for (std::size_t i = text.find(':'); i != std::string_view::npos; i = text.find(':', i + 1)) {
    std::size_t end = i + 1;
    while (end < text.size() && text[end] >= '0' && text[end] <= '9') ++end;
    if (i > 0 && end > i + 1 && end + 1 < text.size() && text[end] == ':' && text[end + 1] == ' ')
      return {std::string(text.substr(0, end)), std::string(text.substr(end + 2))};
    if (i + 1 < text.size() && text[i + 1] == ' ') break;  // a message has begun
  }
  return {"", std::string(text)};
}

void charge(lua_State* L, std::uint64_t units) { state(L).spend(L, units); }

std::string join(std::span<const std::string> words) {
  std::string all;
  for (const std::string& w : words) all += (all.empty() ? "" : ", ") + w;
  return all;
}

namespace {

// What other engines call it; shapes say it in their rows.
struct OtherWord {
  std::string_view word;
  const char* ours;
};
constexpr OtherWord kOtherWords[] = {
    {"rigid_body", "body"},
    {"constraint", "joint"},
    {"collision", "contact_begin"},
    {"collision_enter", "contact_begin"},
    {"collision_exit", "contact_end"},
    {"trigger_enter", "sensor_enter"},
    {"trigger_exit", "sensor_leave"},
    {"trigger", "sensor"},
    {"remove", "destroy"},
    {"delete", "destroy"},
    {"timer", "after"},
    {"timeout", "after"},
    {"interval", "every"},
    {"pos", "position"},
    {"orientation", "rotation"},
    {"bounciness", "restitution"},
    {"bounce", "restitution"},
    {"weight", "mass"},
    {"colour", "color"},
};

// getPosition, GetPosition, get_position -> position; applyForce -> apply_force.
std::string plain_word(std::string_view word) {
  std::string plain;
  for (char c : word) {
    const bool upper = c >= 'A' && c <= 'Z';
    if (upper && !plain.empty() && plain.back() != '_') plain += '_';
    plain += upper ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return plain.starts_with("get_") ? plain.substr(4) : plain;
}

// Those whose word of ours is known.
std::vector<OtherWord> other_words(const std::vector<std::string>& known) {
  std::vector<OtherWord> all(std::begin(kOtherWords), std::end(kOtherWords));
  for (const ShapeKind& kind : shape_kinds())
    for (std::string_view word : split_choices(kind.other_names)) all.push_back({word, kind.name});
  std::erase_if(all, [&](const OtherWord& o) { return std::find(known.begin(), known.end(), o.ours) == known.end(); });
  return all;
}

// The member of `known` that somebody means who writes `word`; "" when there is none.
std::string meant_name(std::string_view word, std::vector<std::string> known) {
  const std::string plain = plain_word(word);
  if (std::find(known.begin(), known.end(), plain) != known.end()) return plain;
  const std::vector<OtherWord> others = other_words(known);
  for (const OtherWord& other : others)
    if (plain == other.word) return other.ours;
  // near a word of ours, or of theirs
  for (const OtherWord& other : others) known.emplace_back(other.word);
  const std::string near = nearest_name(plain, known);
  for (const OtherWord& other : others)
    if (near == other.word) return other.ours;
  return near;
}

}  // namespace

std::string did_you_mean(std::string_view word, const std::vector<std::string>& known) {
  const std::string near = meant_name(word, known);
  return near.empty() ? "" : "; did you mean '" + near + "'?";
}

std::string did_you_mean_or(std::string_view word, const std::vector<std::string>& known) {
  const std::string near = did_you_mean(word, known);
  return near.empty() ? "; known: " + join(known) : near;
}

void add_methods(lua_State* L, std::span<const Method> rows, const std::string& prefix, int metatable) {
  if (metatable) metatable = lua_absindex(L, metatable);
  for (const Method& row : rows) {
    metatable ? lua_pushvalue(L, metatable) : lua_pushnil(L);
    push(L, prefix + row.name);
    lua_pushlightuserdata(L, const_cast<Method*>(&row));  // what tostring shows
    lua_pushcclosure(L, row.fn, 3);
    lua_setfield(L, -2, row.name);
  }
}

std::string method_text(lua_State* L, int index) {
  if (!lua_iscfunction(L, index) || !lua_getupvalue(L, index, 3)) return {};
  const auto* row = lua_islightuserdata(L, -1) ? static_cast<const Method*>(lua_touserdata(L, -1)) : nullptr;
  lua_getupvalue(L, index, 2);
  const std::string name = lua_type(L, -1) == LUA_TSTRING ? lua_tostring(L, -1) : "";
  lua_pop(L, 2);
  if (!row || !name.ends_with(row->name)) return {};
  // methods of all objects have a signature of their own: h:name()
  const std::string_view signature = row->signature;
  const std::size_t at = signature.find(row->name), end = at + std::string_view(row->name).size();
  const bool method = name.find(':') != std::string::npos;
  const bool plain = at != std::string_view::npos && signature.substr(0, at).find(' ') == std::string_view::npos;
  return std::string(method ? "method " : "function ") +
         (plain ? name + std::string(signature.substr(end)) : std::string(signature));
}

void make_class(lua_State* L, Class c, const std::vector<std::span<const Method>>& method_lists) {
  const char* name = class_name(state(L), c);
  lua_newtable(L);
  lua_pushvalue(L, -1);
  state(L).class_ref[static_cast<std::size_t>(c)] = luaL_ref(L, LUA_REGISTRYINDEX);
  const int metatable = lua_gettop(L);
  set_field(L, "__metatable", false);
  set_field(L, "__name", name);
  push(L, name);
  lua_pushcclosure(L, &no_fields, 1);
  lua_setfield(L, metatable, "__newindex");
  lua_newtable(L);
  for (const auto& rows : method_lists) add_methods(L, rows, std::string(name) + ":", metatable);
  // a miss in the method table names the nearest method
  lua_newtable(L);
  push(L, name);
  lua_pushvalue(L, -3);
  lua_pushcclosure(L, &unknown_member, 2);
  lua_setfield(L, -2, "__index");
  lua_setmetatable(L, -2);
  lua_setfield(L, metatable, "__index");
}

void push_class(lua_State* L, Class c) {
  lua_rawgeti(L, LUA_REGISTRYINDEX, state(L).class_ref[static_cast<std::size_t>(c)]);
}

void* self_block(lua_State* L) {
  void* block = lua_touserdata(L, 1);
  if (!block || !lua_getmetatable(L, 1)) return nullptr;
  const bool same = lua_rawequal(L, -1, lua_upvalueindex(1));
  lua_pop(L, 1);
  return same ? block : nullptr;
}

void* test_class(lua_State* L, int index, Class c) {
  index = lua_absindex(L, index);
  if (lua_type(L, index) != LUA_TUSERDATA || !lua_getmetatable(L, index)) return nullptr;
  push_class(L, c);
  const bool same = lua_rawequal(L, -1, -2);
  lua_pop(L, 2);
  return same ? lua_touserdata(L, index) : nullptr;
}

void check_function(lua_State* L, int index) {
  if (lua_type(L, index) != LUA_TFUNCTION) fail_here(L, "expected a function, got " + describe(L, index));
}

void wrong_self(lua_State* L, const char* expected) {
  fail_here(L, std::string("expected a ") + expected + " before the ':', got " + describe(L, 1));
}

}  // namespace feder::lua
