// The files of a stability map, made up by hand: cells, limits, keys, and what the tables say.
#include "report/gate.h"
#include "report/stability_report.h"
#include "report/xml_check.h"
#include "support/catch.h"

using namespace feder;
using namespace feder::report;
using feder::test::count_of;
using feder::test::xml_fault;

namespace {

StabilityResult synthetic_map() {
  StabilityResult r;
  r.real = "float";
  for (const char* method : {"first", "a<b>&c"}) {
    StabilityMap m;
    m.problem = "made_up";
    m.method = method;
    m.x = {"kh2m", "k h²/m", "", true, {0.1, 1, 10}};
    m.y = {"zeta", "damping ratio ζ", "", false, {0, 0.1, 5}};
    for (const double y : m.y.values) {
      for (const double x : m.x.values) {
        StabilityCell c;
        c.x = x, c.y = y;
        c.verdict = x < 4 ? Verdict::stable : Verdict::diverged;
        c.error = 1e-3;
        if (c.verdict == Verdict::diverged) c.entity = "net \"a\", point 7", c.t_fail = 0.5;
        m.cells.push_back(c);
      }
      m.limits.push_back({y, 4, 4.0004, 2, 2.0001});
    }
    m.stable_share = 2.0 / 3;
    r.maps.push_back(m);
  }
  return r;
}

}  // namespace

TEST_CASE("a stability map becomes rows, drawings and a page", "[report]") {
  const StabilityResult r = synthetic_map();
  const auto rows = read_csv(cells_csv(r));
  REQUIRE(rows.size() == 18);
  CHECK(rows[2].at("verdict") == "diverged");
  CHECK(rows[2].at("entity") == "net \"a\", point 7");
  CHECK(read_csv(limits_csv(r)).size() == 6);
  const auto figures = stability_figures(r);
  REQUIRE(figures.size() == 3);
  for (const Figure& f : figures) {
    CAPTURE(f.file);
    CHECK(f.file.find('<') == std::string::npos);
    CHECK(xml_fault(f.svg) == "");
    CHECK(count_of(f.svg, "class=\"cell\"") == (f.file == "sheet.svg" ? 18 : 9));
  }
  const std::vector<ExtremeRow> extreme = {{"mass <0>", "refused", "refused", "mass: expected", true},
                                           {"b", "stands", "fell", "", false}};
  const std::string page = stability_page(r, {}, figures, extreme);
  CHECK(xml_fault(page) == "");
  CHECK(page.find("mass &lt;0&gt;") != std::string::npos);
  CHECK(extreme_table(extreme).find("FAILED") != std::string::npos);
  CHECK(verdict_shares(r.maps[0]) == "66.7 % stable, 33.3 % diverged");
  CHECK(stability_table(r).find("0.0001") != std::string::npos);  // the worst relative deviation
}

TEST_CASE("stability.json has a row per cell with its keys", "[report]") {
  const Json json = Json::parse(to_text(stability_json(synthetic_map(), {})));
  CHECK(json["rows"].size() == 18);
  for (const char* key : {"method", "axes", "verdict", "t_fail", "entity", "error", "energy_ratio", "constraint",
                          "iters_mean", "iters_max", "predicted_limit", "observed_limit"}) {
    CAPTURE(key);
    CHECK(json["rows"][0].contains(key));
  }
  CHECK(json["rows"][0]["axes"]["kh2m"] == 0.1);
  CHECK(json["rows"][0]["observed_limit"] == 4.0004);
}
