// Timers and tasks (coroutines) of one world, in simulated time: they run after a step whose number is known
// beforehand, so nothing drifts and nothing depends on the wall clock.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "lua/state.h"

namespace feder::lua {

struct Timer {
  int function = 0;        // key in the world's callbacks
  std::uint64_t made = 0;  // step count when it was made
  double interval = 0;     // s; 0: once
  std::uint64_t fired = 0;
  std::size_t profile = 0;
};

struct Timers {
  std::map<std::pair<std::uint64_t, std::uint64_t>, Timer> due;  // by (step, id)
  std::uint64_t next_id = 1;
};

enum class TaskState { ready, sleeping, waiting, running, done };

struct Task {
  std::uint64_t id = 0;
  int thread = 0;  // key in the world's callbacks
  TaskState state = TaskState::ready;
  std::uint64_t due = 0;  // step, when sleeping
  std::uint64_t subscription = 0;
  int event = 0;        // key of the copied event to hand over, 0: none
  std::string made_at;  // file:line
  std::size_t profile = 0;
};

struct Tasks {
  std::vector<std::unique_ptr<Task>> list;  // ascending ids: the order in which they run
  std::uint64_t next_id = 1;
  int running = 0;  // tasks on the C stack: the world cannot close meanwhile
};

void run_timers(lua_State* L, WorldRecord& record);
void run_tasks(lua_State* L, WorldRecord& record);
Task* find_task(WorldRecord& record, std::uint64_t id);
bool cancel_timer(lua_State* L, WorldRecord& record, std::uint64_t id);

int world_after(lua_State* L);
int world_every(lua_State* L);
int world_task(lua_State* L);
int feder_wait(lua_State* L);
int feder_wait_until(lua_State* L);
int feder_wait_for(lua_State* L);
std::span<const Method> task_methods();

// A connection: what world:on, after and every return.
enum class ConnectionKind : std::uint32_t { event, timer };
struct Connection {
  std::uint32_t world;
  ConnectionKind kind;
  std::uint64_t id;
};
void push_connection(lua_State* L, const WorldRecord& record, ConnectionKind kind, std::uint64_t id);

struct TaskBlock {
  std::uint32_t world;
  std::uint64_t id;
};

}  // namespace feder::lua
