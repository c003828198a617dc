// Commands by name: what calls the function again that a recording kept. Each system has its list in a file of its own
// (commands_<system>.cpp).
#pragma once
#include <tuple>

#include "feder/record.h"
#include "state/command_codec.h"

namespace feder {

// What commands of a replay share.
struct ReplayState {
  World* world = nullptr;
  std::vector<double> forces;  // answers of the host's forces in the coming step
  std::size_t next_force = 0;
  bool forces_fit = true;
  std::map<std::uint64_t, std::string> images;  // by the hash that they had; those that will be restored
  std::vector<std::uint64_t> restored;          // ascending
};

struct CommandRow {
  const char* name;
  std::string signature;
  void (*run)(ReplayState& state, CommandReader& in);
  ObjectKind first = ObjectKind::none;
};

namespace command {

// How an argument is kept while the function is called, and how it is passed on.
template <class A>
struct Stored {
  using Type = std::remove_cvref_t<A>;
  static const Type& pass(const Type& x) { return x; }
};
template <>
struct Stored<const Vec3*> {
  using Type = std::optional<Vec3>;
  static const Vec3* pass(const Type& x) { return x ? &*x : nullptr; }
};
template <class T>
struct Stored<std::span<const T>> {
  using Type = std::vector<T>;
  static std::span<const T> pass(const Type& x) { return x; }
};
template <>
struct Stored<std::string_view> {
  using Type = std::string;
  static std::string_view pass(const Type& x) { return x; }
};
// By its content; those that are shared come as ShapePtr.
struct ShapeContent {
  ShapePtr shape;
};
template <>
struct Stored<const Shape&> {
  using Type = ShapeContent;
  static const Shape& pass(const Type& x) { return *x.shape; }
};
template <>
struct Stored<WakeCause> {
  using Type = std::string;
  static WakeCause pass(const Type& x) {
    for (const WakeCause& c : kWakeCauses)
      if (x == c.text()) return c;
    return WakeCause::script;
  }
};

template <class T>
void read_stored(CommandReader& in, T& x) {
  if constexpr (std::is_same_v<T, ShapeContent>)
    x.shape = in.content();
  else
    read(in, x);
}

template <class... Args>
std::tuple<typename Stored<Args>::Type...> read_all(CommandReader& in) {
  std::tuple<typename Stored<Args>::Type...> out;
  std::apply([&in](auto&... x) { (read_stored(in, x), ...); }, out);
  if (!in.at_end()) throw SceneError("recording: a command has more arguments than expected");
  return out;
}

template <class... Args>
std::string signature_of() {
  std::string out;
  (sign<std::remove_cvref_t<Args>>(out), ...);
  return out;
}

// The object of a method: the world, its table of objects, or a system.
template <class C>
C& find_owner(World& world) {
  if constexpr (std::is_same_v<C, World>)
    return world;
  else if constexpr (std::is_same_v<C, Objects>)
    return world.objects();
  else {
    C* system = world.find<C>();
    if (!system) throw SceneError(std::string("recording: a command for ") + C::kName + " comes before the system");
    return *system;
  }
}

template <auto Method, class C, class... Args>
CommandRow method_row(const char* name) {
  return {name, signature_of<Args...>(), [](ReplayState& state, CommandReader& in) {
            const auto arguments = read_all<Args...>(in);
            [&]<std::size_t... K>(std::index_sequence<K...>) {
              (find_owner<C>(*state.world).*Method)(Stored<Args>::pass(std::get<K>(arguments))...);
            }
            (std::index_sequence_for<Args...>());
          }};
}

template <auto Method, class R, class C, class... Args>
CommandRow row_of(const char* name, R (C::*)(Args...)) {
  return method_row<Method, C, Args...>(name);
}
template <auto Method, class R, class C, class... Args>
CommandRow row_of(const char* name, R (C::*)(Args...) const) {
  return method_row<Method, C, Args...>(name);
}
template <auto Function, class R, class... Args>
CommandRow row_of(const char* name, R (*)(ReplayState&, Args...)) {
  return {name, signature_of<Args...>(), [](ReplayState& state, CommandReader& in) {
            const auto arguments = read_all<Args...>(in);
            [&]<std::size_t... K>(std::index_sequence<K...>) {
              Function(state, Stored<Args>::pass(std::get<K>(arguments))...);
            }
            (std::index_sequence_for<Args...>());
          }};
}

}  // namespace command

// The row of a method, or of a function whose first argument is the ReplayState. `first`: the kind of the object that
// is its first argument, which must be alive; none for functions that check it.
template <auto Function>
CommandRow command_row(const char* name, ObjectKind first = ObjectKind::none) {
  CommandRow row = command::row_of<Function>(name, Function);
  row.first = first;
  return row;
}

using CommandRows = std::vector<CommandRow>;
// By the name before the dot.
const CommandRow* find_command(std::string_view name);
std::vector<std::string> command_names();

}  // namespace feder
