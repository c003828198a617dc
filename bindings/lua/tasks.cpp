// Timers and tasks.
#include "lua/tasks.h"

#include <algorithm>
#include <cmath>

#include "lua/method.h"

namespace feder::lua {
namespace {

// Steps that last `seconds`; a hair above a whole number is that number.
std::uint64_t whole_steps(const WorldRecord& record, double seconds) {
  const double x = std::ceil(seconds / record.world->desc().dt - 1e-6);
  return static_cast<std::uint64_t>(std::min(std::max(x, 0.0), 1e15));
}

// Steps from now until `seconds` have passed: at least one.
std::uint64_t steps_until(const WorldRecord& record, double seconds) {
  return std::max<std::uint64_t>(1, whole_steps(record, seconds));
}

std::uint64_t now(const WorldRecord& record) { return record.world->step_count(); }

int add_timer(lua_State* L, bool repeat) {
  WorldRecord& r = check_world(L);
  const double seconds = check_number(L, 2, function_name(L), repeat ? kPositive : kNotNegative);
  check_function(L, 3);
  if (r.timers.due.size() >= 1000000) fail_here(L, "expected at most a million timers");
  Timer t;
  t.made = now(r);
  t.interval = repeat ? seconds : 0;
  t.profile = state(L).profile_slot(L, 3);
  t.function = keep(L, r, 3);
  const std::uint64_t id = r.timers.next_id++;
  r.timers.due[{now(r) + steps_until(r, seconds), id}] = t;
  push_connection(L, r, ConnectionKind::timer, id);
  return 1;
}

// Ends a task; its to-be-closed variables close.
void finish_task(lua_State* L, WorldRecord& record, Task& task) {
  task.state = TaskState::done;
  if (task.subscription) unsubscribe(L, record, task.subscription), task.subscription = 0;
  drop(L, record, task.event);
  drop(L, record, task.thread);
  task.event = task.thread = 0;
}

void resume_task(lua_State* L, WorldRecord& record, Task& task) {
  State& s = state(L);
  // its coroutine, with the event that it waited for
  luaL_checkstack(L, 8, "tasks");
  push_data(L, record);
  lua_rawgeti(L, -1, task.thread);
  lua_State* thread = lua_tothread(L, -1);
  int args = lua_status(thread) == LUA_YIELD ? 0 : lua_gettop(thread) - 1;
  if (task.event) {
    lua_rawgeti(L, -2, task.event);
    lua_xmove(L, thread, 1);
    luaL_unref(L, -2, task.event);
    task.event = 0;
    args = 1;
  }
  task.subscription = 0;
  task.state = TaskState::running;

  // tasks nest when one makes another
  struct Outer {
    State& s;
    int& running;
    WorldRecord* world;
    Task* task;
    lua_State* thread;
    ~Outer() { s.task_world = world, s.task = task, s.task_thread = thread, --running; }
  } outer{s, record.tasks.running, s.task_world, s.task, s.task_thread};
  ++record.tasks.running;
  s.task_world = &record, s.task = &task, s.task_thread = thread;

  bool yielded = false;
  Failure failure;
  const bool good = s.profiled(task.profile, [&] { return s.resume(thread, L, args, yielded, failure); });
  lua_pop(L, 2);
  if (!good) {
    failure.message += " (in the task made at " + task.made_at + ")";
    s.report(failure);
  }
  // ended, or where it waits
  if (!record.world) return;
  if (!good || !yielded || task.state == TaskState::done) {
    finish_task(L, record, task);
  } else if (task.state == TaskState::running) {
    task.state = TaskState::sleeping;  // a plain coroutine.yield(): until after the next step
    task.due = now(record) + 1;
  }
}

// The task that calls; an error when the caller is none.
Task& running_task(lua_State* L) {
  State& s = state(L);
  if (!s.task) fail_here(L, "works inside world:task(function() ... end) only");
  if (s.task_thread != L) fail_here(L, "called in another coroutine than the task's own");
  return *s.task;
}

int check_again(lua_State* L, int status, lua_KContext context);

int ask_again(lua_State* L, int, lua_KContext) {
  lua_settop(L, 1);
  lua_pushvalue(L, 1);
  lua_callk(L, 0, 1, 0, check_again);
  return check_again(L, LUA_OK, 0);
}

int check_again(lua_State* L, int, lua_KContext) {
  if (lua_toboolean(L, -1)) return 0;
  Task& task = running_task(L);
  task.state = TaskState::sleeping;
  task.due = now(*state(L).task_world) + 1;
  return lua_yieldk(L, 0, 0, ask_again);
}

Task* self_task(lua_State* L, WorldRecord*& record) {
  const auto* block = static_cast<const TaskBlock*>(self_block(L));
  if (!block) wrong_self(L, "task");
  record = state(L).worlds[block->world].get();
  return record->world ? find_task(*record, block->id) : nullptr;
}

bool task_cancel(lua_State* L) {
  WorldRecord* record = nullptr;
  Task* task = self_task(L, record);
  const bool live = task && task->state != TaskState::done;
  if (live && task->state == TaskState::running) {
    task->state = TaskState::done;  // ends at its next wait
  } else if (live) {
    push_data(L, *record);
    lua_rawgeti(L, -1, task->thread);
    lua_State* thread = lua_tothread(L, -1);
    lua_pop(L, 2);
    finish_task(L, *record, *task);
    if (thread) lua_resetthread(thread);
  }
  return live;
}

bool task_alive(lua_State* L) {
  WorldRecord* record = nullptr;
  const Task* task = self_task(L, record);
  return task && task->state != TaskState::done;
}

const Method kTaskMethods[] = {
    {"cancel", method<task_cancel>, "task:cancel() -> boolean",
     "ends the task where it waits; false when it had ended"},
    {"alive", method<task_alive>, "task:alive() -> boolean", "does the task still run?"},
};

}  // namespace

std::span<const Method> task_methods() { return kTaskMethods; }

void run_timers(lua_State* L, WorldRecord& record) {
  State& s = state(L);
  auto& due = record.timers.due;
  while (!due.empty() && due.begin()->first.first <= now(record)) {
    const std::uint64_t id = due.begin()->first.second;
    Timer t = due.begin()->second;
    due.erase(due.begin());
    push_data(L, record);
    lua_rawgeti(L, -1, t.function);
    lua_remove(L, -2);
    if (t.interval > 0) {
      // counted from the start, so that rounding to steps does not add up; at most once per step
      ++t.fired;
      const std::uint64_t next = t.made + whole_steps(record, static_cast<double>(t.fired + 1) * t.interval);
      due[{std::max(next, now(record) + 1), id}] = t;
    } else {
      drop(L, record, t.function);
    }
    s.call_handler(L, t.profile, 0);
  }
}

void run_tasks(lua_State* L, WorldRecord& record) {
  auto& list = record.tasks.list;
  // tasks made meanwhile have run already
  const std::size_t count = list.size();
  for (std::size_t i = 0; i < count; ++i) {
    Task& t = *list[i];
    if (t.state == TaskState::ready || (t.state == TaskState::sleeping && t.due <= now(record)))
      resume_task(L, record, t);
  }
  std::erase_if(list, [](const auto& t) { return t->state == TaskState::done; });
}

Task* find_task(WorldRecord& record, std::uint64_t id) {
  for (auto& t : record.tasks.list)
    if (t->id == id) return t.get();
  return nullptr;
}

bool cancel_timer(lua_State* L, WorldRecord& record, std::uint64_t id) {
  auto& due = record.timers.due;
  for (auto it = due.begin(); it != due.end(); ++it) {
    if (it->first.second != id) continue;
    drop(L, record, it->second.function);
    due.erase(it);
    return true;
  }
  return false;
}

int world_after(lua_State* L) { return add_timer(L, false); }
int world_every(lua_State* L) { return add_timer(L, true); }

int world_task(lua_State* L) {
  WorldRecord& r = check_world(L);
  check_function(L, 2);
  if (r.tasks.list.size() >= 100000) fail_here(L, "expected at most 100000 tasks");
  auto task = std::make_unique<Task>();
  task->id = r.tasks.next_id++;
  task->made_at = location(L);
  task->profile = state(L).profile_slot(L, 2);
  lua_State* thread = lua_newthread(L);
  lua_pushvalue(L, 2);
  lua_xmove(L, thread, 1);
  task->thread = keep(L, r, -1);
  Task& made = *task;
  r.tasks.list.push_back(std::move(task));
  push_userdata(L, Class::task, TaskBlock{r.id, made.id});
  resume_task(L, r, made);
  return 1;
}

int feder_wait(lua_State* L) {
  Task& task = running_task(L);
  const double seconds = check_number(L, 1, function_name(L), kNotNegative);
  if (task.state == TaskState::running) task.state = TaskState::sleeping;
  task.due = now(*state(L).task_world) + steps_until(*state(L).task_world, seconds);
  return lua_yield(L, 0);
}

int feder_wait_until(lua_State* L) {
  running_task(L);
  check_function(L, 1);
  return ask_again(L, LUA_OK, 0);
}

int feder_wait_for(lua_State* L) {
  Task& task = running_task(L);
  WorldRecord& r = *state(L).task_world;
  const EventKind kind = check_event_kind(L, 1, r);
  EventFilter filter;
  if (!lua_isnoneornil(L, 2)) filter = read_filter(L, 2, r, kind);
  Subscription& s = subscribe(r, kind, filter, {});
  s.task = task.id;
  task.subscription = s.id;
  if (task.state == TaskState::running) task.state = TaskState::waiting;
  return lua_yield(L, 0);
}

}  // namespace feder::lua
