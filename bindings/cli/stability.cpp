// feder stability: verdicts over two axes for every method, with the limit found by bisection beside theory's.
#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "cli/command.h"
#include "cli/progress.h"
#include "cli/scene_files.h"
#include "cli/session.h"
#include "cli/stop.h"
#include "cli/study_parts.h"
#include "cli/test_file.h"
#include "report/stability_report.h"

namespace feder::cli {
namespace {

class Stability final : public Command {
 public:
  void declare(Arguments& a) override {
    a.text("PROBLEM", problem_, "a problem of --list (default oscillator)");
    a.text("--methods", methods_, "methods, comma separated, or all (default)");
    a.text("--suite", suite_,
           "core: a coarse map of every problem; full: the fine ones with bisection; extreme: malformed and extreme "
           "inputs");
    a.text("--axes", axes_, "the axes to map; must be those of the problem (see --list)");
    a.text("--x", x_, "values of the x axis, comma separated (default: the problem's ladder)");
    a.text("--y", y_, "values of the y axis, comma separated");
    a.flag("--bisect", bisect_, "find the limit of each row by bisection");
    a.flag("--list", list_, "list problems and axes");
    a.text("--out", out_, "folder for stability.json, cells.csv, limits.csv, the heat maps and index.html");
  }

  int run(const Options& options) override {
    warn_of_scene_options(options);
    if (list_) return print_list(options);
    const StopSignals signals;
    report::RunContext context;
    context.machine = report::machine_info(FEDER_VERSION, kRealName);
    context.command = command_line();
    if (suite_ == "extreme") return run_extreme_suite(context, options);
    if (!suite_.empty() && suite_ != "core" && suite_ != "full")
      throw Failure(kUsage, "feder stability: unknown suite '{}'; known: core, full, extreme", suite_);
    std::vector<StabilityPlan> plans;
    if (suite_.empty() || !problem_.empty())
      plans.push_back(plan_for(problem_.empty() ? "oscillator" : problem_));
    else
      for (const StabilityProblemInfo& info : stability_problem_infos()) plans.push_back(plan_for(info.name));
    std::size_t finished = 0;
    report::Json all = report::Json::array();
    for (StabilityPlan& plan : plans) {
      if (stop_flag()) break;
      plan.stop = &stop_flag();
      const std::string folder = out_.empty() || plans.size() == 1 ? out_ : out_ + "/" + plan.problem;
      try {
        const StabilityResult result = run_stability(plan);
        if (!result.maps.empty()) finish(result, context, folder, options, plan.problem, all);
        finished += !result.interrupted;
      } catch (const SceneError& e) {
        throw Failure(kUsage, "feder stability {}: {}", plan.problem, e.what());
      }
    }
    if (options.json && plans.size() > 1) print_json(all);
    if (options.json && plans.size() == 1 && !all.empty()) print_json(all[0]);
    return stop_flag() ? report_stop(finished, plans.size(), "problems") : kPass;
  }

 private:
  // The status of a command that had to end.
  static int report_stop(std::size_t done, std::size_t all, const char* what) {
    print_error(fmt::format("feder stability: {}, {} of {} {} are finished", stop_text(), done, all, what));
    return stop_status();
  }

  // Maps are run as their problem and axes say.
  static void warn_of_scene_options(const Options& o) {
    std::vector<const char*> given;
    if (!o.dt.empty()) given.push_back("--dt");
    if (o.threads > 0) given.push_back("--threads");
    if (!o.seed.empty()) given.push_back("--seed");
    if (!o.set.empty()) given.push_back("--set");
    if (!o.world.empty()) given.push_back("--world");
    if (!given.empty())
      fmt::print(stderr, "feder stability: {} {} for scenes: no effect on maps; --x, --y choose values of their axes\n",
                 fmt::join(given, ", "), given.size() == 1 ? "is" : "are");
  }

  int print_list(const Options& options) const {
    report::Json json = report::Json::array();
    for (const StabilityProblemInfo& p : stability_problem_infos()) {
      json.push_back(
          {{"name", p.name}, {"summary", p.summary}, {"axes", {p.x.name, p.y.name}}, {"bisects", p.bisects}});
      if (!options.json)
        fmt::print("{:<12} {}\n             x: {} ({}), {} values; y: {} ({}), {} values{}\n", p.name, p.summary,
                   p.x.name, p.x.label, p.x.values.size(), p.y.name, p.y.label, p.y.values.size(),
                   p.bisects ? "; limits by bisection" : "");
    }
    if (options.json) print_json(json);
    return kPass;
  }

  std::string command_line() const {
    std::vector<std::string> words = {"feder", "stability"};
    if (!problem_.empty()) words.push_back(problem_);
    add_options(words, {{"--suite", suite_}, {"--methods", methods_}, {"--axes", axes_}, {"--x", x_}, {"--y", y_}});
    if (bisect_) words.emplace_back("--bisect");
    add_options(words, {{"--out", out_}});
    return command_text(words);
  }

  static std::vector<double> values(const std::string& text, const char* option) {
    std::vector<double> out;
    for (const std::string& word : split_list(text)) out.push_back(read_number(word, option));
    return out;
  }

  StabilityPlan plan_for(const std::string& problem) const {
    const std::vector<StabilityProblemInfo> infos = stability_problem_infos();
    std::vector<std::string> names;
    for (const StabilityProblemInfo& i : infos) names.push_back(i.name);
    const auto info = std::ranges::find_if(infos, [&](const auto& i) { return i.name == problem; });
    if (info == infos.end())
      throw Failure(kUsage, "feder stability: unknown problem '{}'{}; known: {}", problem,
                    did_you_mean(", ", problem, names), fmt::join(names, ", "));
    StabilityPlan plan;
    plan.problem = problem;
    if (!methods_.empty() && methods_ != "all") plan.methods = split_list(methods_);
    plan.bisect = (bisect_ || suite_ == "full" || suite_.empty()) && info->bisects;
    if (!axes_.empty()) {
      const std::vector<std::string> axes = split_list(axes_);
      const auto known = [&](const std::string& a) { return a == info->x.name || a == info->y.name; };
      if (axes.size() != 2 || !known(axes[0]) || !known(axes[1]) || axes[0] == axes[1])
        throw Failure(kUsage, "feder stability: --axes: {} is mapped over {},{}", problem, info->x.name, info->y.name);
    }
    plan.x_values = values(x_, "--x"), plan.y_values = values(y_, "--y");
    if (suite_ == "core") {
      if (plan.x_values.empty()) plan.x_values = core_values(info->x);
      if (plan.y_values.empty()) plan.y_values = core_values(info->y);
    }
    return plan;
  }

  // What the axis says; else both ends and every second value between.
  static std::vector<double> core_values(const StabilityAxis& axis) {
    if (!axis.core.empty()) return axis.core;
    const std::vector<double>& all = axis.values;
    std::vector<double> out;
    for (std::size_t k = 0; k < all.size(); k += 2) out.push_back(all[k]);
    if (!all.empty() && out.back() != all.back()) out.push_back(all.back());
    return out;
  }

  static void write(const std::string& folder, const StabilityResult& r, const report::RunContext& context,
                    const std::vector<report::ExtremeRow>& extreme) {
    try {
      if (!folder.empty()) report::write_stability(folder, r, context, extreme);
    } catch (const std::runtime_error& e) {
      throw Failure(kFailed, std::string("feder stability: ") + e.what());
    }
  }

  static void finish(const StabilityResult& r, const report::RunContext& context, const std::string& folder,
                     const Options& options, const std::string& problem, report::Json& all) {
    write(folder, r, context, {});
    if (options.json) {
      all.push_back(report::stability_json(r, context));
      return;
    }
    if (!options.quiet) fmt::print("{} ({}): {} methods\n\n", problem, r.real, r.maps.size());
    std::fputs(report::stability_table(r).c_str(), stdout);
    if (!folder.empty() && !options.quiet)
      fmt::print("  wrote {}/index.html, stability.json, cells.csv, limits.csv and the maps\n", folder);
  }

  static void say_left_out(const std::string& what, const std::string& why) {
    print_error(fmt::format("feder stability: {}: left out: {}", what, why));
  }

  // The cases of a test of scenes/extreme, a line that it prints for each: ok or not, input, expected, got, detail,
  // apart by tabs. What ended it, and what went wrong in its handlers, is added to `errors`. What needs a module that
  // this build leaves out is said, and nothing else.
  static void add_extreme_rows(const std::string& file, const Options& options, std::vector<report::ExtremeRow>& rows,
                               std::vector<std::string>& errors) {
    const std::size_t before = rows.size();
    lua::HostOptions host = host_options(options);
    host.print = [&](std::string_view text) {
      const std::vector<std::string> f = split_list(std::string(text.substr(0, text.find('\n'))), '\t');
      if (f.size() == 5) rows.push_back({f[1], f[2], f[3], f[4], f[0] == "ok"});
      if (f.size() == 3 && f[0] == "left out") say_left_out(f[1], f[2]);
    };
    const auto add_error = [&](const std::string& error) { errors.push_back(error); };
    try {
      Session(std::move(host), add_error, file).need_to_go_on();
    } catch (const Failure& e) {
      if (stop_flag()) return;
      const std::string what = e.what();
      const std::size_t lacks = what.find("this build leaves out");
      if (lacks != std::string::npos && rows.size() == before) return say_left_out(file, what.substr(lacks));
      // a case that is not as expected is an error too, at the end of its script
      if (e.status() != kFailed || rows.size() == before) throw;
      add_error(e.what());
    }
    if (rows.size() == before) throw Failure(kNothingRan, file + ": prints no case");
  }

  int run_extreme_suite(const report::RunContext& context, const Options& options) const {
    // the cases say all that worlds are made of
    Options own;
    own.build = options.build, own.limit = options.limit, own.memory = options.memory;
    const auto folder = (scenes_folder() / "extreme").lexically_proximate(std::filesystem::current_path());
    const std::vector<std::string> files = find_files({folder.string()}, is_plain_test);
    std::vector<report::ExtremeRow> rows;
    std::vector<std::string> errors;
    Progress bar(!options.quiet && !options.json);
    std::size_t finished = 0;
    for (; finished < files.size() && !stop_flag(); finished += !stop_flag()) {
      const std::string& file = files[finished];
      if (bar.due()) bar.show(static_cast<double>(finished) / static_cast<double>(files.size()), file);
      add_extreme_rows(file, own, rows, errors);
    }
    // page, table, sum
    StabilityResult none;
    none.real = kRealName;
    write(out_, none, context, rows);
    std::fputs((options.json ? report::to_text(report::extreme_json(rows)) : report::extreme_table(rows)).c_str(),
               stdout);
    const auto passed =
        static_cast<std::size_t>(std::ranges::count_if(rows, [](const report::ExtremeRow& e) { return e.pass; }));
    if (!options.json && !options.quiet) fmt::print("  {} of {} as expected\n", passed, rows.size());
    for (const std::string& error : errors) print_error(error);
    if (stop_flag()) return report_stop(finished, files.size(), "files");
    if (rows.empty() && errors.empty()) return kNothingRan;
    return passed < rows.size() || !errors.empty() ? kFailed : kPass;
  }

  std::string problem_, methods_, suite_, axes_, x_, y_, out_;
  bool bisect_ = false, list_ = false;
};

}  // namespace

Row cli_stability() {
  return command_row<Stability>("stability", "stability maps of every method, with the limits found beside theory's");
}

}  // namespace feder::cli
