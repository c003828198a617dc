#include "cli/summary.h"

#include <fmt/format.h>

#include "report/table.h"

namespace feder::cli {
namespace {

// "9 bodies, 1 cloth (425 vertices), 1 fluid (700 particles)"
std::string counts_text(const Summary& s) {
  const auto many = [](std::size_t n, const char* one, const char* more) {
    return fmt::format("{} {}", n, n == 1 ? one : more);
  };
  std::string text;
  for (const KindCount& k : s.counts) {
    if (k.count == 0) continue;
    text += (text.empty() ? "" : ", ") + many(k.count, k.kind.text(), k.kind.plural());
    if (k.parts) text += " (" + many(k.part_count, k.parts->unit, k.parts->units) + ")";
  }
  return text.empty() ? "nothing" : text;
}

}  // namespace

std::string hash_text(std::uint64_t hash) { return fmt::format("{:016x}", hash); }

Summary summarize(Session& session) {
  Summary s;
  World* world = session.world();
  if (!world) return s;
  s.seconds = world->time();
  s.threads = world->desc().threads;
  s.counts = world->counts();
  s.hash = hash_text(world->hash());
  s.energy = world->energy();
  s.finite = world->is_finite();
  return s;
}

std::string summary_text(Session& session, const Summary& s) {
  std::string text = fmt::format("{}\n", session.title());
  const double ms = session.step_milliseconds(), all_ms = ms * static_cast<double>(session.steps());
  text += fmt::format("  time    {:g} s simulated{}, {} steps, {:.3f} ms/step ({:.3g} x real time), {} thread{}\n",
                      s.seconds, s.interrupted ? " (interrupted)" : "", session.steps(), ms,
                      all_ms > 0 ? s.seconds * 1000 / all_ms : 0, s.threads, s.threads == 1 ? "" : "s");
  text += "  counts  " + counts_text(s) + "\n";
  text += fmt::format("  energy  kinetic {:.6g} J, potential {:.6g} J, elastic {:.6g} J\n", s.energy.kinetic,
                      s.energy.potential, s.energy.elastic);
  if (!s.finite) text += "  state   NOT FINITE\n";
  if (!s.hash.empty()) text += fmt::format("  hash    {}\n", s.hash);
  for (const auto& h : session.script().handler_profile())
    if (h.calls)
      text += fmt::format("  lua     {}: {} calls, {:.3f} ms\n", h.where, h.calls,
                          static_cast<double>(h.nanoseconds) * 1e-6);
  for (const Warning& w : session.warnings())
    text += fmt::format("  warning {} ({} x): {}\n", w.code, w.count, w.message);
  for (const auto& e : session.script().handler_errors())
    text += fmt::format("  error   {} ({} x)\n", error_text(e), e.count);
  return text;
}

report::Json handlers_json(Session& session) {
  report::Json handlers = report::Json::array();
  for (const auto& h : session.script().handler_profile())
    handlers.push_back({{"where", h.where}, {"calls", h.calls}, {"ms", static_cast<double>(h.nanoseconds) * 1e-6}});
  return handlers;
}

report::Json summary_json(Session& session, const Summary& s) {
  report::Json warnings = report::Json::array(), errors = report::Json::array();
  for (const Warning& w : session.warnings())
    warnings.push_back({{"code", w.code}, {"message", w.message}, {"count", w.count}});
  for (const auto& e : session.script().handler_errors())
    errors.push_back({{"where", e.where}, {"message", e.message}, {"count", e.count}});
  report::Json all = {
      {"title", session.title()},
      {"scene", session.file()},
      {"seconds", s.seconds},
      {"steps", session.steps()},
      {"ms_per_step", session.step_milliseconds()},
      {"threads", s.threads},
      {"real", kRealName},
      {"hash", s.hash},
      {"energy", {{"kinetic", s.energy.kinetic}, {"potential", s.energy.potential}, {"elastic", s.energy.elastic}}},
      {"finite", s.finite},
      {"interrupted", s.interrupted},
      {"warnings", warnings},
      {"handler_errors", errors},
      {"handlers", handlers_json(session)}};
  for (const KindCount& k : s.counts) {
    all[k.kind.plural()] = k.count;
    if (k.parts) all[k.parts->units] = k.part_count;
  }
  return all;
}

std::string profile_text(Session& session, std::uint64_t steps) {
  if (steps == 0) return "";
  const StepPlan& plan = session.world()->plan();
  const double sum = plan.total_nanoseconds(), per_step = 1e-6 / static_cast<double>(steps);
  report::Table table({"pass", "system", ">calls", ">ms/step", ">share"});
  double around[kLoopCount] = {static_cast<double>(steps)};  // iterations of the loop at a depth
  for (const PlanNode& n : plan.nodes()) {
    const double ns = n.counter.total_nanoseconds();
    const auto depth = static_cast<std::size_t>(StepPlan::depth(n));
    std::string name = std::string(2 * depth, ' ') + n.name;
    if (n.is_loop) {
      around[depth + 1] = static_cast<double>(n.counter.calls);
      name += fmt::format(" x {:.3g}", around[depth] > 0 ? around[depth + 1] / around[depth] : 0);
    }
    table.add({name, n.system, fmt::format("{}", n.counter.calls), fmt::format("{:.4f}", ns * per_step),
               fmt::format("{:.1f} %", sum > 0 ? 100 * ns / sum : 0)});
  }
  std::string text = table.text("  ");
  report::Table lua({"Lua handler", ">calls", ">ms/call"});
  for (const auto& h : session.script().handler_profile())
    if (h.calls)
      lua.add({h.where, fmt::format("{}", h.calls),
               fmt::format("{:.4f}", static_cast<double>(h.nanoseconds) * 1e-6 / static_cast<double>(h.calls))});
  if (!lua.empty()) text += "\n" + lua.text("  ");
  return text;
}

}  // namespace feder::cli
