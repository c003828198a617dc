// feder diff: two recordings, and the first step, object and quantity in which they part.
// Both are done again side by side; where this build does not give the state that a recording has kept, it says so,
// and what can be known from the hashes alone.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "cli/recording.h"
#include "cli/stop.h"
#include "cli/summary.h"
#include "report/states.h"

namespace feder::cli {
namespace {

constexpr std::size_t kMaxRows = 10;        // objects that are listed
constexpr std::uint64_t kMaxHidden = 1000;  // steps to wait for a difference of objects behind one of the hash

// A number of an object in both worlds.
struct Difference {
  std::string object, quantity, unit;
  double size = 0, a = 0, b = 0;  // of the component that differs most
};

class Comparison {
 public:
  // All objects that are not the same in both, the largest difference first.
  static std::vector<Difference> of(World& a, World& b) {
    Comparison c{a, b, {}};
    std::uint32_t most = 0;
    for (World* w : {&a, &b})
      for (const report::StateReader& r : report::state_readers())
        w->objects().for_each(r.kind, [&](ObjectId id) { most = std::max(most, id.slot + 1); });
    for (std::uint32_t slot = 0; slot < most; ++slot) c.compare(a.objects().at(slot), b.objects().at(slot));
    std::stable_sort(c.found.begin(), c.found.end(),
                     [](const Difference& x, const Difference& y) { return x.size > y.size; });
    return c.found;
  }

  World &a, &b;
  std::vector<Difference> found;

 private:
  void compare(ObjectId x, ObjectId y) {
    const report::StateReader *reader = report::state_reader(a, x), *other = report::state_reader(b, y);
    if (!reader && !other) return;
    if (!reader || !other || reader != other || x != y) {
      for (const auto& [world, id, there] : {std::tuple{&a, x, reader}, std::tuple{&b, y, other}})
        if (there)
          found.push_back({world->objects().describe(id), world == &a ? "only in the first" : "only in the second", "",
                           INFINITY, 0, 0});
      return;
    }
    report::ObjectState s, t;
    s.clear(), t.clear();
    reader->read(a, x, s), reader->read(b, y, t);
    const std::string name = a.objects().describe(x);
    if (reader->rigid) {
      add(name, "position", "m", s.pose.position, t.pose.position);
      const Quat &p = s.pose.rotation, &q = t.pose.rotation;
      add(name, "rotation", "", p.vec(), q.vec());
      if (p.w != q.w) keep({name, "rotation", "", std::abs(double(p.w) - double(q.w)), p.w, q.w});
      add(name, "velocity", "m/s", s.velocity, t.velocity);
      add(name, "angular velocity", "rad/s", s.angular_velocity, t.angular_velocity);
      return;
    }
    if (s.positions.size() != t.positions.size())
      return keep({name, "number of points", "", INFINITY, double(s.positions.size()), double(t.positions.size())});
    for (std::size_t i = 0; i < s.positions.size(); ++i) {
      const std::string point = " of point " + std::to_string(i + 1);
      add(name, "position" + point, "m", s.positions[i], t.positions[i]);
      add(name, "velocity" + point, "m/s", s.velocities[i], t.velocities[i]);
    }
  }

  void add(const std::string& object, const std::string& quantity, const char* unit, const Vec3& x, const Vec3& y) {
    for (int k = 0; k < 3; ++k)
      if (x[k] != y[k])
        keep({object, quantity + (quantity == "rotation" ? "" : std::string(".") + "xyz"[k]), unit,
              std::abs(double(x[k]) - double(y[k])), x[k], y[k]});
  }

  // One row for an object: its largest difference.
  void keep(const Difference& d) {
    if (!found.empty() && found.back().object == d.object) {
      if (d.size > found.back().size || std::isnan(d.size)) found.back() = d;
    } else {
      found.push_back(d);
    }
  }
};

struct Side {
  std::string file;
  Recording recording;
  std::unique_ptr<Replay> replay;
  std::vector<RecordedCommand> commands;
  bool more = true;
};

class Diff final : public Command {
 public:
  void declare(Arguments& arguments) override {
    arguments.text("FIRST", file_[0], "a recording");
    arguments.require("FIRST");
    arguments.text("SECOND", file_[1], "another one");
    arguments.require("SECOND");
  }

  bool runs_scenes() const override { return false; }
  bool makes_worlds() const override { return true; }

  int run(const Options& options) override {
    const StopSignals signals;
    Side a{file_[0], read_recording(file_[0]), {}, {}, true}, b{file_[1], read_recording(file_[1]), {}, {}, true};
    compare_facts(a.recording, b.recording);
    const std::size_t worlds = std::min(a.recording.world_count(), b.recording.world_count());
    for (std::size_t k = 0; k < worlds && json_["state"].is_null() && stop_reason() == StopReason::none; ++k)
      compare_worlds(a, b, k, options);
    if (a.recording.world_count() != b.recording.world_count())
      say(fmt::format("worlds: {} and {}", a.recording.world_count(), b.recording.world_count()));
    if (stop_reason() != StopReason::none) {
      print_error("feder diff: " + stop_text());
      return stop_status();
    }
    json_["same"] = lines_.empty();
    if (options.json) {
      print_json(json_);
    } else {
      for (const std::string& line : lines_) fmt::print("{}\n", line);
      if (!lines_.empty() && !facts_.empty()) fmt::print("the runs:\n{}", facts_);
      if (lines_.empty() && !options.quiet) fmt::print("the same: every command and every hash\n");
    }
    return lines_.empty() ? kPass : kFailed;
  }

 private:
  void say(const std::string& line) { lines_.push_back(line); }

  // Other builds and scripts are no difference by themselves, but what a reader wants to know beside one.
  void compare_facts(const Recording& a, const Recording& b) {
    json_ = {{"same", true},
             {"facts", report::Json::array()},
             {"command", nullptr},
             {"state", nullptr},
             {"objects", report::Json::array()}};
    std::vector<std::string> names;
    for (const Recording* r : {&a, &b})
      for (const auto& [name, text] : r->facts())
        if (std::ranges::find(names, name) == names.end()) names.push_back(name);
    for (const std::string& name : names) {
      const std::string x = all_of(a, name), y = all_of(b, name);
      if (x == y) continue;
      const bool file = name.starts_with("file ");
      facts_ += fmt::format("  {}: {}\n", name, file ? "another text" : fmt::format("'{}' and '{}'", x, y));
      json_["facts"].push_back({{"name", name}, {"first", x}, {"second", y}});
    }
  }

  // --set may be there several times.
  static std::string all_of(const Recording& recording, const std::string& name) {
    std::string out;
    for (const auto& [key, text] : recording.facts())
      if (key == name) out += (out.empty() ? "" : " ") + text;
    return out;
  }

  void compare_worlds(Side& a, Side& b, std::size_t number, const Options& options) {
    const std::string world = a.recording.world_count() > 1 ? fmt::format("world {} ", number + 1) : "";
    for (Side* s : {&a, &b}) s->replay = make_replay(s->file, s->recording, number, options), s->more = true;
    std::uint64_t step = 0, hidden = 0;
    bool commands_part = false;
    while (a.more && b.more && stop_reason() == StopReason::none) {
      for (Side* s : {&a, &b}) s->more = step_replay(s->file, *s->replay, &s->commands);
      ++step;
      if (!commands_part) commands_part = compare_commands(a, b, world, step);
      if (!a.more || !b.more) break;
      const bool kept = a.replay->has_hash() && b.replay->has_hash();
      const bool kept_part = kept && a.replay->hash() != b.replay->hash();
      const bool part = a.replay->world().hash() != b.replay->world().hash();
      if (kept_part && !part) return say_builds(a, b, world, number + 1, step);
      if (!part) continue;
      if (hidden == 0) json_["state"] = {{"world", number + 1}, {"step", step}, {"time", a.replay->world().time()}};
      const std::vector<Difference> found = Comparison::of(a.replay->world(), b.replay->world());
      if (!found.empty()) return say_objects(found, world, step, hidden);
      if (++hidden > kMaxHidden) return say_hidden(world, step - hidden + 1);
    }
    if (hidden > 0) return say_hidden(world, step - hidden);
    if (a.more != b.more) {
      say(fmt::format("{}steps: {} and {}", world, a.recording.steps(number), b.recording.steps(number)));
      json_["state"] = {{"world", number + 1}, {"step", step}, {"time", a.replay->world().time()}};
    }
  }

  bool compare_commands(const Side& a, const Side& b, const std::string& world, std::uint64_t step) {
    for (std::size_t k = 0; k < std::max(a.commands.size(), b.commands.size()); ++k) {
      const RecordedCommand* x = k < a.commands.size() ? &a.commands[k] : nullptr;
      const RecordedCommand* y = k < b.commands.size() ? &b.commands[k] : nullptr;
      if (x && y && x->name == y->name && x->arguments == y->arguments) continue;
      say(fmt::format("{}before step {} another thing is done:\n  first   {}\n  second  {}", world, step,
                      x ? x->text : "nothing more", y ? y->text : "nothing more"));
      json_["command"] = {{"step", step}, {"first", x ? x->text : ""}, {"second", y ? y->text : ""}};
      return true;
    }
    return false;
  }

  // The same commands give the same state here, but not where they were recorded.
  void say_builds(Side& a, Side& b, const std::string& world, std::size_t number, std::uint64_t step) {
    say(
        fmt::format("{}step {}: the hashes part, but this build gives the same state for both: they were recorded by "
                    "builds that differ\n  first   {}{}\n  second  {}{}",
                    world, step, recorded_by(a.recording), a.replay->same() ? " (as this build)" : "",
                    recorded_by(b.recording), b.replay->same() ? " (as this build)" : ""));
    json_["state"] = {{"world", number}, {"step", step}, {"time", a.replay->world().time()}};
  }

  void say_hidden(const std::string& world, std::uint64_t step) {
    say(fmt::format("{}step {}: the state parts in what no object shows (contacts, impulses, sleep)", world, step));
  }

  void say_objects(const std::vector<Difference>& found, const std::string& world, std::uint64_t step,
                   std::uint64_t hidden) {
    if (hidden > 0) say_hidden(world, step - hidden);
    std::string text =
        fmt::format("{}step {}: {} object{} part", world, step, found.size(), found.size() == 1 ? "" : "s");
    for (std::size_t k = 0; k < std::min(found.size(), kMaxRows); ++k) {
      const Difference& d = found[k];
      const std::string unit = d.unit.empty() ? "" : " " + d.unit;
      text += std::isinf(d.size) && d.a == 0 && d.b == 0
                  ? fmt::format("\n  {}: {}", d.object, d.quantity)
                  : fmt::format("\n  {}: {} {:.9g} and {:.9g}{}, {:.3g}{} apart", d.object, d.quantity, d.a, d.b, unit,
                                std::abs(d.a - d.b), unit);
      json_["objects"].push_back(
          {{"object", d.object}, {"quantity", d.quantity}, {"unit", d.unit}, {"first", d.a}, {"second", d.b}});
    }
    if (found.size() > kMaxRows) text += fmt::format("\n  ... and {} more", found.size() - kMaxRows);
    say(text);
  }

  std::string file_[2];
  std::vector<std::string> lines_;
  std::string facts_;  // that differ
  report::Json json_;
};

}  // namespace

Row cli_diff() {
  return command_row<Diff>("diff", "names the first step, object and quantity in which recordings part");
}

}  // namespace feder::cli
