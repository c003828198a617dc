// feder study: error against cost of every method on a problem with a reference: tables, CSV, JSON, SVG and one page.
#include "feder/study.h"

#include <algorithm>
#include <charconv>
#include <cstdio>

#include "cli/command.h"
#include "cli/point_log.h"
#include "cli/progress.h"
#include "cli/stop.h"
#include "cli/study_parts.h"
#include "report/gate.h"
#include "report/study_identity.h"
#include "report/study_page.h"

namespace feder::cli {
namespace {

using report::StudyContext;

// Runs that failed where the suite does not allow it, one line each.
void list_broken(const SuiteRow& row, const StudyResult& r, std::vector<std::string>& lines) {
  const auto allowed = [&](const std::string& method) {
    return std::ranges::find(row.may_diverge, method) != row.may_diverge.end();
  };
  for (const StudyPoint& p : r.points)
    if (!report::succeeded(p) && !allowed("*") && !allowed(p.method))
      lines.push_back(fmt::format("{}: {} at {}: {}{}{}", report::problem_label(r.problem), p.method,
                                  report::rung_text(p), name_of(p.status), p.reason.empty() ? "" : ": ", p.reason));
}

class Study final : public Command {
 public:
  void declare(Arguments& a) override {
    a.list("PROBLEM", words_,
           "a problem (see --list), a .lua or .yaml scene, or with --merge the report.json files of shards");
    a.text("--methods", methods_, "methods, comma separated, or all (default)");
    a.list("--ladder", ladders_,
           "rungs: h:1e-1..1e-5:x2, tol:1e-2..1e-12:x10, iters:1..256:x2, substeps:1,4,16, steps:60,600 (may be "
           "repeated)");
    a.text("--boxes", boxes_, "with broad_phase: the boxes of this scene's colliders in its first 257 steps");
    a.text("--budget", budget_, "force=1e6: most work of one run, in force evaluations of the whole problem");
    a.text("--error", errors_,
           "norms to plot, the first one everywhere: "
           "end,traj,max,energy,drift,momentum,angular,constraint,event,orient,horizon");
    a.text("--axis", axes_, "cost axes: time,force (default both)");
    a.whole("--repeat", repeat_, 0, 1000, "timed repeats of each run at least; 0 times nothing (default 5)");
    a.text("--shard", shard_,
           "I/N: run only every N-th point, I from 1 to N (0 is N). With GNU parallel: "
           "parallel feder study oscillator --shard {}/8 --out part{} ::: 1 2 3 4 5 6 7 8; "
           "feder study --merge part*/report.json --out whole");
    a.flag("--resume", resume_, "go on with a study that was stopped: points in OUT/points.jsonl are not run again");
    a.flag("--merge", merge_, "put the reports of shards together; exit status 1 for holes and foreign shards");
    a.text("--baseline", baseline_, "a points.csv or report.json to compare with; exit status 1 when it differs");
    a.text("--gate", gate_, "what --baseline compares: cost,error (default), size");
    a.flag("--list", list_, "list problems, parameters and references");
    a.text("--suite", suite_, "run a suite of problems; exit status 1 when a run diverges that must not");
    a.text("--out", out_,
           "folder for report.json, points.csv, *.svg and index.html; points.jsonl grows as points finish");
    a.text("--markdown", markdown_, "write the picture's link and the table of the cheapest methods as Markdown");
    a.text("--picture", picture_, "the picture's link in the Markdown (default: error_vs_work.svg in --out)");
  }

  int run(const Options& options) override {
    check_words();
    if (list_) return print_list(options);
    if (merge_) return merge(options);
    const StopSignals signals;
    if (!suite_.empty()) return run_suite(options);
    if (words_.size() != 1)
      throw Failure(kUsage, "feder study: expected one PROBLEM or scene (feder study --list names them)");
    if (resume_ && out_.empty()) throw Failure(kUsage, "feder study: --resume needs the --out of the stopped study");
    StudyContext context = new_context(options);
    const auto problem = boxes_.empty() ? open_problem(words_[0], options) : open_boxes(boxes_, options);
    const std::string file = boxes_.empty() ? problem_file(words_[0]) : boxes_;
    const StudyResult result = sweep(*problem, file, options, methods_, ladders_, context, out_);
    context.machine.load_after = report::load_now();
    return check_and_finish(result, context, options);
  }

 private:
  void check_words() const {
    for (const std::string& name : split_list(errors_))
      if (!report::find_norm(name))
        throw Failure(kUsage, "feder study: --error: unknown norm '{}'{}; known: {}", name,
                      did_you_mean(", ", name, report::norm_names()), fmt::join(report::norm_names(), ", "));
    for (const std::string& name : split_list(axes_))
      if (name != "time" && name != "force")
        throw Failure(kUsage, "feder study: --axis: expected time or force, got '{}'", name);
    for (const std::string& name : split_list(gate_))
      if (name != "cost" && name != "error" && name != "size")
        throw Failure(kUsage, "feder study: --gate: expected cost, error or size, got '{}'", name);
    if (!boxes_.empty() && words_ != std::vector<std::string>{"broad_phase"})
      throw Failure(kUsage, "feder study: --boxes: expected the problem broad_phase, got '{}'", fmt::join(words_, " "));
    if (!gate_.empty() && baseline_.empty()) throw Failure(kUsage, "feder study: --gate needs a --baseline");
  }

  static int print_list(const Options& options) {
    const std::string text = options.json ? report::to_text(problem_list_json(options)) : problem_list_text(options);
    std::fputs(text.c_str(), stdout);
    return kPass;
  }

  StudyContext new_context(const Options& options) const {
    StudyContext c;
    c.machine = report::machine_info(FEDER_VERSION, kRealName);
    c.command = command_line(options);
    if (!errors_.empty()) c.errors = split_list(errors_);
    if (!axes_.empty()) c.axes = split_list(axes_);
    // options that differ from their defaults: words in pairs
    std::vector<std::string> words;
    add_options(words, {{"--methods", methods_}});
    for (const std::string& ladder : ladders_) add_options(words, {{"--ladder", ladder}});
    add_options(words, {{"--boxes", boxes_}, {"--budget", budget_}, {"--repeat", repeat_text()}, {"--shard", shard_}});
    Options without_set = options;
    without_set.set.clear();
    add_scene_options(words, without_set);
    for (std::size_t k = 0; k < words.size(); k += 2) c.settings.push_back(words[k] + " " + words[k + 1]);
    return c;
  }

  std::string repeat_text() const { return repeat_ == kRepeats ? "" : std::to_string(repeat_); }

  std::string command_line(const Options& options) const {
    std::vector<std::string> words = {"feder", "study"};
    if (merge_) words.emplace_back("--merge");
    words.insert(words.end(), words_.begin(), words_.end());
    add_scene_options(words, options);
    add_options(words, {{"--suite", suite_}, {"--methods", methods_}});
    for (const std::string& ladder : ladders_) add_options(words, {{"--ladder", ladder}});
    add_options(words, {{"--boxes", boxes_},
                        {"--budget", budget_},
                        {"--error", errors_},
                        {"--axis", axes_},
                        {"--shard", shard_},
                        {"--seed", options.seed},
                        {"--repeat", repeat_text()},
                        {"--baseline", baseline_},
                        {"--gate", gate_},
                        {"--out", out_}});
    return command_text(words);
  }

  // What was asked for besides the plan, and where it runs.
  Provenance provenance(const Options& options, const StudyContext& context, const std::string& scene) const {
    std::vector<std::string> given = options.set;
    given.insert(given.end(), options.world.begin(), options.world.end());
    if (!options.dt.empty()) given.push_back("dt=" + options.dt);
    if (!options.seed.empty()) given.push_back("seed=" + options.seed);
    if (!boxes_.empty()) given.push_back("boxes of " + boxes_);
    if (!budget_.empty()) given.push_back("budget " + budget_);
    Provenance p;
    p.overrides = fmt::format("{}", fmt::join(given, "; "));
    p.real = context.machine.real, p.git = context.machine.git, p.tool = context.machine.tool;
    p.build = context.machine.compiler + " " + context.machine.flags;
    if (!scene.empty()) p.scene_hash = report::file_hash(scene);
    return p;
  }

  // `log_folder`: where finished points go; empty for nowhere.
  // `file`: of a scene.
  StudyResult sweep(const StudyProblem& problem, const std::string& file, const Options& options,
                    const std::string& methods, const std::vector<std::string>& ladders, const StudyContext& context,
                    const std::string& log_folder) const {
    SweepOptions o;
    o.machine = context.machine.cpu;
    Progress bar(!options.quiet && !options.json);
    o.progress = [&](double done, const std::string& where) {
      if (bar.due()) bar.show(done, where);
    };
    o.limits.stop = &stop_flag();
    if (methods != "all") o.methods = split_list(methods);
    if (!budget_.empty()) o.limits.budget_work = read_budget();
    o.timing.enabled = repeat_ > 0;
    o.timing.min_repeats = std::max(1, repeat_);
    o.timing.max_repeats = std::max(o.timing.max_repeats, repeat_);
    if (!shard_.empty()) read_shard(o);
    try {
      for (const std::string& ladder : ladders) o.ladders.push_back(parse_ladder(ladder));
      StudyResult known;
      known.problem = problem.info();
      known.provenance = provenance(options, context, file);
      const std::vector<PlannedPoint> plan = plan_sweep(problem, o);
      known.provenance.plan_hash = report::plan_hash(plan);
      known.planned = plan.size();
      std::optional<PointLog> log;
      if (!log_folder.empty()) {
        log.emplace(log_folder, report::identity_json(known), resume_);
        if (resume_ && !options.quiet) fmt::print(stderr, "feder study: {} points are there\n", log->restored());
        log->attach(o);
      }
      StudyResult result = run_sweep(problem, o);
      result.provenance = known.provenance;
      report::round_series(result);
      return result;
    } catch (const SceneError& e) {
      throw Failure(kUsage, "feder study {}: {}", problem.info().name, e.what());
    }
  }

  double read_budget() const {
    if (!budget_.starts_with("force="))
      throw Failure(kUsage, "feder study: --budget: expected force=NUMBER, got '{}'", budget_);
    const double budget = read_number(budget_.substr(6), "--budget force");
    if (!(budget > 0)) throw Failure(kUsage, "feder study: --budget: expected more than 0 force evaluations");
    return budget;
  }

  void read_shard(SweepOptions& o) const {
    const std::size_t slash = shard_.find('/');
    int i = -1, n = 0;
    const auto whole = [](const std::string& text, int& value) {
      const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
      return error == std::errc() && end == text.data() + text.size();
    };
    if (slash == std::string::npos || !whole(shard_.substr(0, slash), i) || !whole(shard_.substr(slash + 1), n)) i = -1;
    if (n < 1 || i < 0 || i > n)
      throw Failure(kUsage, "feder study: --shard: expected I/N with I from 1 to N, got '{}'", shard_);
    o.shard = i % n;
    o.shards = n;
  }

  int merge(const Options& options) const {
    if (words_.empty()) throw Failure(kUsage, "feder study: --merge expects the report.json files of shards");
    StudyContext context = new_context(options);
    const StudyResult whole = merge_reports(words_, context.machine);
    return check_and_finish(whole, context, options);
  }

  int check_and_finish(const StudyResult& result, StudyContext& context, const Options& options) const {
    if (!stop_flag()) gate({&result, 1}, context);
    if (!result.points.empty()) finish(result, context, out_, options);
    if (stop_flag()) return report_stop(result.points.size(), result.planned, "points");
    return violated(context) ? kFailed : kPass;
  }

  // The status of a command that had to end.
  int report_stop(std::size_t done, std::size_t all, const char* what) const {
    print_error(fmt::format("feder study: {}, {} of {} {} are finished{}", stop_text(), done, all, what,
                            out_.empty() || !suite_.empty() ? "" : "; --resume goes on"));
    return stop_status();
  }

  int run_suite(const Options& options) {
    if (!words_.empty()) throw Failure(kUsage, "feder study: --suite takes no PROBLEM");
    StudyContext context = new_context(options);
    std::vector<StudyResult> all;
    std::vector<std::string> broken;
    const std::vector<SuiteRow> rows = suite_rows(suite_);
    for (const SuiteRow& row : rows) {
      if (stop_flag()) break;
      Options of_row = options;
      of_row.set = row.set;
      const auto problem = open_problem(row.problem, of_row);
      const std::string methods = fmt::format("{}", fmt::join(row.methods, ","));
      all.push_back(sweep(*problem, problem_file(row.problem), of_row, methods, row.ladders, context, ""));
      const StudyResult& r = all.back();
      if (r.points.empty()) {  // stopped
        all.pop_back();
        break;
      }
      list_broken(row, r, broken);
      if (!out_.empty())
        finish(r, context, out_ + "/" + report::file_name(report::problem_label(r.problem)), options, true);
      if (!options.quiet && !options.json)
        fmt::print("{}: {} points\n", report::problem_label(r.problem), r.points.size());
    }
    context.machine.load_after = report::load_now();
    if (!stop_flag()) gate(all, context);
    if (!out_.empty() && !all.empty()) {
      report::write_text(out_ + "/points.csv", report::points_csv(all, true));
      report::write_text(out_ + "/index.html", report::suite_page(suite_, all, context));
    }
    if (options.json)
      print_json({{"suite", suite_}, {"problems", all.size()}, {"diverged", broken}, {"gate", context.gate}});
    for (const std::string& line : broken) fmt::print(stderr, "{}\n", line);
    print_violations(context);
    if (stop_flag()) return report_stop(all.size(), rows.size(), "problems");
    return violated(context) || !broken.empty() ? kFailed : kPass;
  }

  void gate(std::span<const StudyResult> results, StudyContext& context) const {
    if (baseline_.empty()) return;
    report::GateTiers tiers;
    if (!gate_.empty()) {
      const std::vector<std::string> names = split_list(gate_);
      const auto has = [&](const char* name) { return std::ranges::find(names, name) != names.end(); };
      tiers.cost = has("cost"), tiers.error = has("error"), tiers.size = has("size");
    }
    std::vector<double> floors;
    for (const StudyResult& r : results) floors.insert(floors.end(), r.points.size(), r.problem.reference.floor());
    const std::string csv = report::points_csv(results, !suite_.empty());
    try {
      context.gate =
          report::check_gate(baseline_, report::read_baseline(baseline_), report::read_csv(csv), floors, tiers);
    } catch (const std::runtime_error& e) {
      throw Failure(kUsage, std::string("feder study: --baseline: ") + e.what());
    }
  }

  static bool violated(const StudyContext& c) { return !c.gate.empty() && !c.gate.at("violations").empty(); }

  static void print_violations(const StudyContext& c) {
    if (c.gate.empty()) return;
    for (const report::Json& v : c.gate.at("violations"))
      fmt::print(stderr, "gate: {}: {} was {}, is {} (limit: {})\n", v.value("point", ""), v.value("field", ""),
                 v.at("was").dump(), v.at("now").dump(), v.value("limit", ""));
  }

  void finish(const StudyResult& r, const StudyContext& context, const std::string& folder, const Options& options,
              bool silent = false) const {
    try {
      if (!folder.empty()) report::write_study(folder, r, context);
      const std::string drawn = folder.empty() ? "" : folder + "/error_vs_work.svg";
      if (!markdown_.empty() && !silent)
        report::write_text(markdown_, report::study_markdown(r, picture_.empty() ? drawn : picture_));
    } catch (const std::runtime_error& e) {
      throw Failure(kFailed, std::string("feder study: ") + e.what());
    }
    if (silent) return;
    if (options.json) {
      print_json(report::study_json(r, context));
    } else {
      std::fputs(report::study_summary(r, options.quiet).c_str(), stdout);
      if (!folder.empty() && !options.quiet)
        fmt::print("  wrote {}/index.html, report.json, points.csv and the figures\n", folder);
    }
    std::fflush(stdout);
    print_violations(context);
  }

  static constexpr int kRepeats = 5;
  std::vector<std::string> words_, ladders_;
  std::string methods_, boxes_, budget_, errors_, axes_, shard_, baseline_, gate_, suite_, out_, markdown_, picture_;
  int repeat_ = kRepeats;
  bool merge_ = false, list_ = false, resume_ = false;
};

}  // namespace

Row cli_study() {
  return command_row<Study>("study", "error against run time and work, with figures and a table of what to pick");
}

}  // namespace feder::cli
