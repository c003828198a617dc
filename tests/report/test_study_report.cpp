// The files of a study: golden bytes, columns, keys, and the way back from JSON.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "report/gate.h"
#include "report/study_identity.h"
#include "report/study_page.h"
#include "report/synthetic.h"
#include "report/xml_check.h"
#include "support/catch.h"

using namespace feder;
using namespace feder::report;
using feder::test::count_of;
using feder::test::synthetic_study;
using feder::test::xml_fault;

namespace {

const std::string kGolden = FEDER_SOURCE_DIR "/tests/golden/report/";

std::string read_all(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

// The stored bytes; FEDER_WRITE_GOLDEN=1 stores new ones.
void check_golden(const std::string& name, const std::string& text) {
  if (std::getenv("FEDER_WRITE_GOLDEN")) write_text(kGolden + name, text);
  CAPTURE(name);
  CHECK(text == read_all(kGolden + name));
}

const Figure& figure(const std::vector<Figure>& figures, const std::string& file) {
  for (const Figure& f : figures)
    if (f.file == file) return f;
  FAIL("no figure " + file);
  return figures[0];
}

}  // namespace

TEST_CASE("a made up study has the stored bytes", "[report]") {
  const StudyResult r = synthetic_study();
  const auto figures = study_figures(r, {});
  check_golden("points.csv", points_csv(r));
  check_golden("error_vs_work.svg", figure(figures, "error_vs_work.svg").svg);
  check_golden("order.svg", figure(figures, "order.svg").svg);
  check_golden("table.txt", study_summary(r, false));
  check_golden("pick.md", study_markdown(r, "error_vs_work.svg"));
}

TEST_CASE("an order that misses theory is marked in the terminal and on the page", "[report]") {
  StudyResult r = synthetic_study();
  CHECK_THAT(study_summary(r, false), !Catch::Contains("  order   "));
  r.fits[0].slope = r.fits[0].expected - 1.02;
  const std::string words = r.fits[0].method + ": fitted ";
  CHECK_THAT(study_summary(r, false), Catch::Contains("  order   " + words));
  const std::string page = study_page(r, {}, {});
  CHECK_THAT(page, Catch::Contains("miss theory by more than a quarter") && Catch::Contains(words));
}

TEST_CASE("the figures keep every point and escape names", "[report]") {
  const StudyResult r = synthetic_study();
  const auto figures = study_figures(r, {});
  for (const char* file : {"error_vs_time.svg", "error_vs_work.svg"}) {
    const std::string& svg = figure(figures, file).svg;
    CHECK(count_of(svg, "class=\"point") == static_cast<int>(r.points.size()));
    CHECK(count_of(svg, "class=\"point failed\"") == 3);
  }
  for (const Figure& f : figures) {
    CAPTURE(f.file);
    CHECK(xml_fault(f.svg) == "");
    CHECK(f.svg.find("a<b>") == std::string::npos);
    // the row of points.csv is in the point's title
    if (f.file == "error_vs_work.svg") CHECK(f.svg.find("made_up,first,1,0.125,,,,ok") != std::string::npos);
  }
  const std::string page = study_page(r, {}, figures);
  CHECK(xml_fault(page) == "");
  CHECK(page.find("<script") == std::string::npos);
  CHECK(page.find("http") == page.find("http://www.w3.org/2000/svg"));
  CHECK(count_of(page, "<svg ") == static_cast<int>(figures.size()));
}

TEST_CASE("points.csv has its columns", "[report]") {
  const StudyResult r = synthetic_study();
  const auto rows = read_csv(points_csv(r));
  REQUIRE(rows.size() == r.points.size());
  CHECK(rows[0].size() == 43);
  CHECK(rows[5].at("method") == feder::test::kNasty);
  CHECK(rows[5].at("status") == "nan");
  CHECK(rows[5].at("err_end") == "");
  CHECK(std::stod(rows[4].at("err_end")) == r.points[4].err_end);
  CHECK_THROWS_WITH(read_csv("a,b\n1\n"), Catch::Contains("line 2"));
}

TEST_CASE("report.json has its keys and comes back whole", "[report]") {
  const StudyResult r = synthetic_study();
  StudyContext context;
  context.machine = machine_info("0", "float");
  const Json json = Json::parse(to_text(study_json(r, context)));
  CHECK(json.at("schema") == "accuracy/1");
  for (const char* key : {"run", "problem", "methods", "points", "fits", "front", "cost_to_accuracy", "gate"})
    CHECK(json.contains(key));
  for (const char* key : {"git", "tool", "date", "build", "machine"}) CHECK(json["run"].contains(key));
  for (const char* key : {"compiler", "flags", "real", "fma", "ftz"}) CHECK(json["run"]["build"].contains(key));
  for (const char* key : {"cpu", "cores", "os", "virtual", "load_before", "load_after", "timer_resolution_ns"})
    CHECK(json["run"]["machine"].contains(key));
  for (const char* key : {"name", "params", "t_end", "dof", "x_scale", "v_scale", "E_scale", "chaotic", "reference"})
    CHECK(json["problem"].contains(key));
  for (const char* key : {"kind", "digits", "uncertainty", "source"}) CHECK(json["problem"]["reference"].contains(key));
  for (const char* key : {"name", "order", "evals_per_step", "limit_hw", "implicit"})
    CHECK(json["methods"][0].contains(key));
  for (const char* key : {"method", "slope", "expected", "rms", "range"}) CHECK(json["fits"][0].contains(key));
  for (const char* key : {"target", "method", "force_evals", "time_s"})
    CHECK(json["cost_to_accuracy"][0].contains(key));
  for (const char* key : {"baseline", "violations"}) CHECK(json["gate"].contains(key));
  CHECK(json["methods"][2]["limit_hw"] == "inf");
  for (const char* key : {"hash", "overrides", "threads", "real", "git", "scene_hash", "plan_hash"})
    CHECK(json["study"].contains(key));
  CHECK(altered_fields(json) == std::vector<std::string>{"run.git", "run.tool", "run.build.real"});  // none was given
  // every column of points.csv is a key of a point, but the problem's name and what all points have in common
  std::istringstream header(csv_header());
  for (std::string column; std::getline(header, column, ',');) {
    CAPTURE(column);
    if (column != "problem") CHECK((json["points"][0].contains(column) || json["study"].contains(column)));
  }
  StudyResult back = study_from_json(json);
  evaluate(back);
  CHECK(points_csv(back) == points_csv(r));
  CHECK(to_text(study_json(back, context)) == to_text(study_json(r, context)));
  CHECK(study_figures(back, context)[1].svg == study_figures(r, context)[1].svg);
  CHECK_THROWS_WITH(study_from_json(Json::object()), Catch::Contains("accuracy/1"));
  Json broken = json;
  broken.erase("points");
  CHECK_THROWS_WITH(study_from_json(broken), Catch::Contains("points"));
}

TEST_CASE("the decision table names the cheapest method and where it ends", "[report]") {
  const auto rows = decisions(synthetic_study());
  REQUIRE(rows.size() >= 3);
  CHECK(rows[0].target == 0.1);
  CHECK(rows[0].reached);
  CHECK(rows[0].by_work.method == "first");  // 10 evaluations against 16 of the second and 32 of the fourth
  CHECK(rows[2].by_work.method == "fourth");
  CHECK_FALSE(rows.back().reached);
}

TEST_CASE("the gate sees counts, errors and missing points, and no seconds", "[report]") {
  const StudyResult r = synthetic_study();
  const auto was = read_csv(points_csv(r));
  const std::vector<double> floors(was.size(), r.problem.reference.floor());
  const auto violations = [&](const std::vector<CsvRow>& now, const GateTiers& tiers = {}) {
    return check_gate("was.csv", was, now, floors, tiers).at("violations").size();
  };
  CHECK(violations(was) == 0);
  auto now = was;
  now[0]["t_min_s"] = "1";
  CHECK(violations(now) == 0);
  now[0]["force_evals"] = "9";
  CHECK(violations(now) == 1);
  CHECK(violations(now, {false, true, false}) == 0);
  now = was;
  now[1]["err_end"] = "0.0626";  // 0.0625 within a thousandth times 2
  CHECK(violations(now) == 1);
  now[1]["err_end"] = "0.06251";
  CHECK(violations(now) == 0);
  now = was;
  now[0]["status"] = "diverged";
  CHECK(violations(now) == 1);
  now.pop_back();
  CHECK(check_gate("was.csv", was, now, floors, {}).at("violations").size() == 2);
}
