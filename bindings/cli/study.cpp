// feder study: error against cost of every method on a problem with a reference: tables, CSV, JSON, SVG and one page.
#include "feder/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdio>

#include "cli/command.h"
#include "cli/point_log.h"
#include "cli/progress.h"
#include "cli/study_parts.h"
#include "report/gate.h"
#include "report/study_identity.h"
#include "report/study_page.h"

namespace feder::cli {
namespace {

using report::StudyContext;

bool failed(const StudyPoint& p) { return p.status != PointStatus::ok && p.status != PointStatus::slow; }

class Study final : public Command {
 public:
  void declare(Arguments& a) override {
    a.list("PROBLEM", words_,
           "a problem (see --list), a .lua or .yaml scene, or with --merge the report.json files of shards");
    a.text("--methods", methods_, "methods, comma separated, or all (default)");
    a.list("--ladder", ladders_,
           "rungs: h:1e-1..1e-5:x2, tol:1e-2..1e-12:x10, iters:1..256:x2, substeps:1,4,16, steps:60,600 (may be "
           "repeated)");
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
    if (!suite_.empty()) return run_suite(options);
    if (words_.size() != 1)
      throw Failure(kUsage, "feder study: expected one PROBLEM or scene (feder study --list names them)");
    if (resume_ && out_.empty()) throw Failure(kUsage, "feder study: --resume needs the --out of the stopped study");
    StudyContext context = new_context(options);
    const auto problem = open_problem(words_[0], options);
    StudyResult result = sweep(*problem, problem_file(words_[0]), options, methods_, ladders_, context, out_);
    context.machine.load_after = report::load_now();
    gate({&result, 1}, context);
    finish(result, context, out_, options);
    return violated(context) ? kFailed : kPass;
  }

 private:
  void check_words() const {
    for (const std::string& name : split_list(errors_))
      if (!report::find_norm(name)) {
        const std::string near = nearest_name(name, report::norm_names());
        throw Failure(kUsage, fmt::format("feder study: --error: unknown norm '{}'{}; known: {}", name,
                                          near.empty() ? "" : ", did you mean '" + near + "'?",
                                          fmt::join(report::norm_names(), ", ")));
      }
    for (const std::string& name : split_list(axes_))
      if (name != "time" && name != "force")
        throw Failure(kUsage, fmt::format("feder study: --axis: expected time or force, got '{}'", name));
    for (const std::string& name : split_list(gate_))
      if (name != "cost" && name != "error" && name != "size")
        throw Failure(kUsage, fmt::format("feder study: --gate: expected cost, error or size, got '{}'", name));
    if (!gate_.empty() && baseline_.empty()) throw Failure(kUsage, "feder study: --gate needs a --baseline");
  }

  int print_list(const Options& options) const {
    std::fputs((options.json ? report::to_text(problem_list_json(options)) : problem_list_text(options)).c_str(),
               stdout);
    return kPass;
  }

  StudyContext new_context(const Options& options) const {
    StudyContext c;
    c.machine = report::machine_info(FEDER_VERSION, kRealName);
    c.command = command_line(options);
    if (!errors_.empty()) c.errors = split_list(errors_);
    if (!axes_.empty()) c.axes = split_list(axes_);
    const auto differs = [&](const char* name, const std::string& value) {
      if (!value.empty()) c.settings.push_back(fmt::format("{} {}", name, value));
    };
    differs("--methods", methods_);
    for (const std::string& ladder : ladders_) differs("--ladder", ladder);
    differs("--budget", budget_);
    if (repeat_ != kRepeats) differs("--repeat", std::to_string(repeat_));
    differs("--shard", shard_);
    for (const std::string& w : options.world) differs("--world", w);
    differs("--dt", options.dt);
    if (options.threads > 0) differs("--threads", std::to_string(options.threads));
    return c;
  }

  std::string command_line(const Options& options) const {
    std::string out = "feder study";
    const auto add = [&](const std::string& word) {
      out += " " + (word.find(' ') == std::string::npos ? word : "'" + word + "'");
    };
    if (merge_) add("--merge");
    for (const std::string& w : words_) add(w);
    const auto option = [&](const char* name, const std::string& value) {
      if (!value.empty()) add(name), add(value);
    };
    for (const std::string& s : options.set) option("--set", s);
    for (const std::string& s : options.world) option("--world", s);
    option("--dt", options.dt);
    if (options.threads > 0) option("--threads", std::to_string(options.threads));
    option("--suite", suite_), option("--methods", methods_);
    for (const std::string& l : ladders_) option("--ladder", l);
    option("--budget", budget_), option("--error", errors_), option("--axis", axes_), option("--shard", shard_),
        option("--seed", options.seed);
    if (repeat_ != kRepeats) option("--repeat", std::to_string(repeat_));
    option("--baseline", baseline_), option("--gate", gate_), option("--out", out_);
    return out;
  }

  // What was asked for besides the plan, and where it runs.
  Provenance provenance(const Options& options, const StudyContext& context, const std::string& scene) const {
    Provenance p;
    const auto add = [&](const std::string& word) { p.overrides += (p.overrides.empty() ? "" : "; ") + word; };
    for (const std::string& s : options.set) add(s);
    for (const std::string& w : options.world) add(w);
    if (!options.dt.empty()) add("dt=" + options.dt);
    if (!options.seed.empty()) add("seed=" + options.seed);
    if (!budget_.empty()) add("budget " + budget_);
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
      throw Failure(kUsage, fmt::format("feder study {}: {}", problem.info().name, e.what()));
    }
  }

  double read_budget() const {
    if (!budget_.starts_with("force="))
      throw Failure(kUsage, fmt::format("feder study: --budget: expected force=NUMBER, got '{}'", budget_));
    const double budget = read_number(budget_.substr(6), "--budget force");
    if (!(budget > 0)) throw Failure(kUsage, "feder study: --budget: expected more than 0 force evaluations");
    return budget;
  }

  void read_shard(SweepOptions& o) const {
    const std::size_t slash = shard_.find('/');
    int i = -1, n = 0;
    const char* const text = shard_.c_str();
    if (slash != std::string::npos) {
      const bool good = std::from_chars(text, text + slash, i).ptr == text + slash &&
                        std::from_chars(text + slash + 1, text + shard_.size(), n).ptr == text + shard_.size();
      if (!good) i = -1;
    }
    if (n < 1 || i < 0 || i > n)
      throw Failure(kUsage, fmt::format("feder study: --shard: expected I/N with I from 1 to N, got '{}'", shard_));
    o.shard = i % n;
    o.shards = n;
  }

  int merge(const Options& options) const {
    if (words_.empty()) throw Failure(kUsage, "feder study: --merge expects the report.json files of shards");
    StudyContext context = new_context(options);
    StudyResult whole = merge_reports(words_, context.machine);
    gate({&whole, 1}, context);
    finish(whole, context, out_, options);
    return violated(context) ? kFailed : kPass;
  }

  int run_suite(const Options& options) {
    if (!words_.empty()) throw Failure(kUsage, "feder study: --suite takes no PROBLEM");
    StudyContext context = new_context(options);
    std::vector<StudyResult> all;
    std::vector<std::string> broken;
    for (const SuiteRow& row : suite_rows(suite_)) {
      Options of_row = options;
      of_row.set = row.set;
      const auto problem = open_problem(row.problem, of_row);
      const std::string methods = fmt::format("{}", fmt::join(row.methods, ","));
      all.push_back(sweep(*problem, problem_file(row.problem), of_row, methods, row.ladders, context, ""));
      const StudyResult& r = all.back();
      for (const StudyPoint& p : r.points) {
        const auto& may = row.may_diverge;
        if (!failed(p) || std::find(may.begin(), may.end(), "*") != may.end() ||
            std::find(may.begin(), may.end(), p.method) != may.end())
          continue;
        broken.push_back(fmt::format("{}: {} at {}: {}{}{}", report::problem_label(r.problem), p.method,
                                     report::rung_text(p), name_of(p.status), p.reason.empty() ? "" : ": ", p.reason));
      }
      if (!out_.empty())
        finish(r, context, out_ + "/" + report::file_name(report::problem_label(r.problem)), options, true);
      if (!options.quiet && !options.json)
        fmt::print("{}: {} points\n", report::problem_label(r.problem), r.points.size());
    }
    context.machine.load_after = report::load_now();
    gate(all, context);
    std::string csv = report::csv_header() + "\n";
    for (const StudyResult& r : all)
      for (const StudyPoint& p : r.points) csv += report::csv_row(report::problem_label(r.problem), r, p) + "\n";
    if (!out_.empty()) {
      report::write_text(out_ + "/points.csv", csv);
      report::write_text(out_ + "/index.html", report::suite_page(suite_, all, context));
    }
    if (options.json)
      std::fputs(
          report::to_text({{"suite", suite_}, {"problems", all.size()}, {"diverged", broken}, {"gate", context.gate}})
              .c_str(),
          stdout);
    for (const std::string& line : broken) fmt::print(stderr, "{}\n", line);
    print_violations(context);
    return violated(context) || !broken.empty() ? kFailed : kPass;
  }

  void gate(std::span<const StudyResult> results, StudyContext& context) const {
    if (baseline_.empty()) return;
    report::GateTiers tiers;
    if (!gate_.empty()) {
      const std::vector<std::string> names = split_list(gate_);
      const auto has = [&](const char* name) { return std::find(names.begin(), names.end(), name) != names.end(); };
      tiers.cost = has("cost"), tiers.error = has("error"), tiers.size = has("size");
    }
    std::string csv = report::csv_header() + "\n";
    std::vector<double> floors;
    for (const StudyResult& r : results)
      for (const StudyPoint& p : r.points) {
        csv += report::csv_row(
                   results.size() > 1 || !suite_.empty() ? report::problem_label(r.problem) : r.problem.name, r, p) +
               "\n";
        floors.push_back(r.problem.reference.floor());
      }
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
      if (!markdown_.empty() && !silent)
        report::write_text(markdown_,
                           report::study_markdown(
                               r, picture_.empty() ? (folder.empty() ? "" : folder + "/error_vs_work.svg") : picture_));
    } catch (const std::runtime_error& e) {
      throw Failure(kFailed, std::string("feder study: ") + e.what());
    }
    if (silent) return;
    if (options.json) {
      std::fputs(report::to_text(report::study_json(r, context)).c_str(), stdout);
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
  std::string methods_, budget_, errors_, axes_, shard_, baseline_, gate_, suite_, out_, markdown_, picture_;
  int repeat_ = kRepeats;
  bool merge_ = false, list_ = false, resume_ = false;
};

}  // namespace

Row cli_study() {
  return {"study", "error against run time and work, with figures and a table of what to pick",
          [] { return std::unique_ptr<Command>(new Study); }};
}

}  // namespace feder::cli
