// The references of the problems against the digits printed in numerics.md 2.
#include "study/problem.h"
#include "support/catch.h"

using namespace feder;

namespace {

struct Expected {
  const char* problem;
  std::vector<const char*> options;
  double t;
  std::vector<double> x, v;  // leading components; empty: not printed
  double tolerance;
};

const Expected kExpected[] = {
    {"oscillator", {}, 10, {-0.83907152907645245}, {0.54402111088936981}, 1e-14},
    {"oscillator", {"stiffness=100"}, 1, {-0.83907152907645245}, {5.4402111088936981}, 1e-14},
    {"oscillator", {"stiffness=1e4"}, 1, {0.86231887228768393}, {50.636564110975879}, 1e-13},
    {"oscillator", {"stiffness=1e6"}, 1, {0.56237907629070299}, {-826.87954053200256}, 1e-12},
    {"oscillator", {"stiffness=1e8"}, 1, {-0.95215536825901485}, {3056.1438888825214}, 1e-11},
    {"oscillator", {"stiffness=100", "damping=2"}, 1, {-0.33685168059041336}, {1.8534570698460590}, 1e-14},
    {"oscillator", {"stiffness=100", "damping=20"}, 0.5, {0.040427681994512803}, {-0.33689734995427335}, 1e-14},
    {"oscillator", {"stiffness=100", "damping=101"}, 0.02, {0.98873264694382745}, {-0.85339736370721476}, 1e-14},
    {"oscillator", {"stiffness=100", "damping=101"}, 1, {0.37159539512266901}, {-0.37159539512266901}, 1e-14},
    {"oscillator", {"stiffness=1e4", "damping=2"}, 1, {0.31441524479692606}, {18.787475439247370}, 1e-13},
};

}  // namespace

TEST_CASE("references have the printed digits", "[study]") {
  for (const Expected& e : kExpected) {
    Params options;
    for (const char* o : e.options) set_option(options, o);
    const auto problem = make_study_problem(e.problem, options);
    Observation at;
    problem->reference(e.t, at);
    for (std::size_t i = 0; i < e.x.size(); ++i) {
      CAPTURE(e.problem, e.options, e.t, i);
      CHECK(at.x.at(i) == Approx(e.x[i]).epsilon(0).margin(e.tolerance * problem->info().x_scale));
    }
    for (std::size_t i = 0; i < e.v.size(); ++i) {
      CAPTURE(e.problem, e.options, e.t, i);
      CHECK(at.v.at(i) == Approx(e.v[i]).epsilon(0).margin(e.tolerance * problem->info().v_scale));
    }
  }
}
