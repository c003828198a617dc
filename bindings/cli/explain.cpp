// feder explain: what a scene uses and what it leaves out: systems, passes of the step plan, bytes, share of time.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "cli/command.h"
#include "cli/session.h"
#include "cli/summary.h"
#include "report/table.h"

namespace feder::cli {
namespace {

constexpr int kSteps = 10;  // enough for shares that repeat, fast for every scene

class Explain final : public Command {
 public:
  void declare(Arguments& a) override {
    a.text("SCENE", scene_, "a .lua or .yaml file");
    a.require("SCENE");
    a.whole("--steps", steps_, 1, 1000000, fmt::format("steps that are timed (default {})", kSteps));
  }

  int run(const Options& options) override {
    Session session(silent_host_options(options), print_error, scene_);
    World* world = session.world();
    if (!world) throw Failure(kFailed, scene_ + ": this script makes no world");
    std::uint64_t steps = world->step_count();
    if (session.is_scene()) {
      session.step();  // the first one fills caches and makes room
      world->reset_profile();
      world->clock_every(1);
      for (int i = 0; i < steps_; ++i) {
        session.need_to_go_on();
        session.step();
      }
      session.need_to_go_on();
      steps = static_cast<std::uint64_t>(steps_);
    }
    std::fputs((options.json ? report::to_text(json(session, steps)) : text(session, steps)).c_str(), stdout);
    return session.script().handler_errors().empty() ? kPass : kFailed;
  }

 private:
  // Arenas of the world itself: events, scratch and what systems share.
  static std::vector<std::pair<std::string, std::size_t>> shared_arenas(World& world) {
    std::vector<std::pair<std::string, std::size_t>> rows;
    const auto systems = world.report();
    for (const auto& arena : world.store().arenas()) {
      const auto is_own = [&](const SystemReport& s) { return s.name == arena->name(); };
      if (std::ranges::none_of(systems, is_own)) rows.emplace_back(arena->name(), arena->bytes());
    }
    rows.emplace_back("objects", world.objects().bytes());
    return rows;
  }

  static report::Json advice_json(Session& session) {
    report::Json rows = report::Json::array();
    const auto json = [](const auto& value) -> report::Json {
      if constexpr (std::is_same_v<std::decay_t<decltype(value)>, double>)
        if (std::isinf(value)) return nullptr;  // JSON has no infinity: null is no limit
      return value;
    };
    for (const lua::Advice& a : session.script().advice()) {
      report::Json& row = rows.emplace_back(report::Json::object());
      row["object"] = session.world()->objects().describe(a.object);
      row["text"] = a.text;
      for (const auto& [name, fact] : a.facts) row[name] = std::visit(json, fact);
    }
    return rows;
  }

  static report::Json json(Session& session, std::uint64_t steps) {
    World& world = *session.world();
    report::Json systems = report::Json::array(), plan = report::Json::array();
    for (const SystemReport& s : world.report())
      systems.push_back(
          {{"name", s.name}, {"count", s.count}, {"unit", s.units}, {"bytes", s.bytes}, {"notes", s.notes}});
    const double sum = world.plan().total_nanoseconds();
    const double per_step = steps ? 1e-6 / static_cast<double>(steps) : 0;
    for (const PlanNode& n : world.plan().nodes()) {
      const double ns = n.counter.total_nanoseconds();
      plan.push_back({{"name", n.name},
                      {"system", n.system},
                      {"path", StepPlan::path(n)},
                      {"kind", n.is_loop ? "loop" : "pass"},
                      {n.is_loop ? "count" : "calls", n.counter.calls},
                      {"ms", ns * per_step},
                      {"share", sum > 0 ? ns / sum : 0}});
    }
    report::Json memory = report::Json::object();
    for (const auto& [name, bytes] : shared_arenas(world)) memory[name] = bytes;
    return {{"title", session.title()},
            {"scene", session.file()},
            {"steps", steps},
            {"systems", systems},
            {"absent", world.absent()},
            {"plan", plan},
            {"memory", memory},
            {"bytes", world.bytes()},
            {"handlers", handlers_json(session)},
            {"advice", advice_json(session)}};
  }

  static std::string text(Session& session, std::uint64_t steps) {
    World& world = *session.world();
    report::Table systems({"system", ">count", "of", ">bytes"});
    for (const SystemReport& s : world.report())
      systems.add({s.name, fmt::format("{}", s.count), s.units, report::bytes_text(s.bytes)});
    report::Table absent({"not used", ">bytes"});
    for (const std::string& name : world.absent()) absent.add({name, "0"});
    report::Table memory({"world", ">bytes"});
    for (const auto& [name, bytes] : shared_arenas(world)) memory.add({name, report::bytes_text(bytes)});
    std::string out = session.title() + "\n\n" + systems.text("  ") + "\n";
    if (!absent.empty()) out += absent.text("  ") + "\n";
    out += memory.text("  ") + "\n";
    bool noted = false;
    for (const SystemReport& s : world.report())
      for (const std::string& note : s.notes) out += "  " + s.name + ": " + note + "\n", noted = true;
    if (noted) out += "\n";
    const std::vector<lua::Advice> advice = session.script().advice();
    for (const lua::Advice& a : advice) out += "  " + a.text + "\n";
    if (!advice.empty()) out += "\n";
    const int substeps = world.desc().substeps;
    out += fmt::format("one step, {} substep{}, mean of {}:\n\n", substeps, substeps == 1 ? "" : "s", steps);
    return out + profile_text(session, steps);
  }

  std::string scene_;
  int steps_ = kSteps;
};

}  // namespace

Row cli_explain() {
  return command_row<Explain>("explain",
                              "shows what a scene uses and leaves out: systems, the tree of passes, bytes, time");
}

}  // namespace feder::cli
