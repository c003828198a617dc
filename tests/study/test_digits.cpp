// The references of the problems against printed digits.
#include "feder/study.h"
#include "study/reference.h"
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
    {"kepler",
     {"e=0.9", "periods=8"},
     1,
     {-1.1871884663458634, 0.41752763873976423},
     {-0.76114201052149136, -0.099472047870273486},
     1e-14},
    {"kepler", {"e=0.9", "periods=8"}, 3.141592653589793, {-1.9, 0}, {0, -0.22941573387056177}, 1e-14},
    {"kepler",
     {"e=0.9", "periods=8"},
     10,
     {-1.8538537094055792, -0.13088540483992555},
     {0.16156945255843134, -0.22371927679189709},
     1e-13},
    {"kepler",
     {"e=0.9", "periods=8"},
     50,
     {-0.39638433862766916, -0.37657740302346457},
     {1.5801267192087493, 0.40150456641286024},
     1e-13},
    {"pendulum", {"theta0=1"}, 1, {0.60008536612750644}, {}, 1e-14},
    {"pendulum", {"theta0=1"}, 10, {-0.99894981462385065}, {-0.042033377534212294}, 1e-14},
    {"pendulum", {}, 10, {-0.94686245325590347}, {-1.0809554582362733}, 1e-14},
    {"pendulum", {"theta0=3"}, 10, {-2.6506745635982096}, {0.46495609836143063}, 1e-14},
    {"pendulum", {"theta0=3.1241393610698500"}, 1, {3.1146614424194608}, {}, 1e-13},
    {"pendulum", {"theta0=3.1241393610698500"}, 10, {-3.0574358436666280}, {-0.082301761587637116}, 1e-12},
    {"double_pendulum",
     {},
     1,
     {-0.62508769980639063, -1.0345850856800123},
     {-3.9222795728879766, -1.3030992486963312},
     1e-14},
    {"double_pendulum",
     {},
     2,
     {-0.48297153425175438, -1.3240487123023625},
     {3.0652881920734013, 2.9492715475715716},
     1e-14},
    {"double_pendulum",
     {"t_end=10"},
     5,
     {-0.62718670506653073, -1.3013155502098117},
     {2.1254086738429107, 3.8818887272656074},
     1e-12},
    {"double_pendulum",
     {"t_end=10"},
     10,
     {-0.56847466401595019, -0.52639372793240470},
     {6.0783848857619649, -9.6813606817088788},
     1e-9},
    {"spring_pendulum", {"stiffness=100"}, 1, {-0.98019693612978, -0.61505532144325}, {}, 2e-14},
    {"spring_pendulum", {}, 1, {-0.98619230515608, -0.16857139113810}, {}, 2e-14},
    {"spring_pendulum", {}, 2, {0.78716337934129, -0.61969057482201}, {}, 2e-14},
    {"spring_pendulum", {"stiffness=1e6"}, 1, {-0.98629074280213, -0.16504631169752}, {}, 2e-13},
    {"spring_pendulum", {"stiffness=1e6"}, 2, {0.79350278087262, -0.60859605452638}, {}, 2e-13},
    {"swinging_chain", {"stiffness=1e4"}, 1, {-0.894395250, -0.140767555}, {}, 1e-9},
    {"swinging_chain", {"stiffness=1e4", "ratio=1000"}, 1, {0.219595663, -3.339980577}, {}, 1e-9},
    {"swinging_chain", {}, 1, {-0.913242528, -0.149728450}, {}, 1e-9},
    {"swinging_chain", {"ratio=1000"}, 1, {-0.986563152, -0.200692777}, {}, 1e-9},
    // relaxation: the first creep and jump; the whole run takes long and is no other test
    {"van_der_pol", {}, 500, {1.596768951052661760}, {-1.030391187839356666e-3}, 1e-13},
    {"prothero_robinson", {}, 2, {-0.41614683654714239}, {}, 1e-15},
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

TEST_CASE("elliptic integrals and functions", "[study]") {
  // T = 4 K(sin^2(theta0/2)) for theta0 = 1, pi/2, 3
  const double periods[][2] = {
      {1, 6.6999756643704527}, {1.5707963267948966, 7.4162987092054877}, {3, 16.155539372393375}};
  for (const auto& [angle, period] : periods) {
    const Wide c = std::cos(static_cast<Wide>(angle) / 2);
    CHECK(static_cast<double>(4 * elliptic_k(c * c)) == Approx(period).epsilon(1e-15));
  }
  // sn^2 + cn^2 = 1, dn^2 + m sn^2 = 1, and the quarter period
  const Wide m = 0.7L, quarter = elliptic_k(1 - m);
  Wide sn, cn, dn;
  jacobi_elliptic(0.37L, m, 1 - m, sn, cn, dn);
  CHECK(static_cast<double>(sn * sn + cn * cn) == Approx(1).epsilon(1e-16));
  CHECK(static_cast<double>(dn * dn + m * sn * sn) == Approx(1).epsilon(1e-16));
  jacobi_elliptic(quarter, m, 1 - m, sn, cn, dn);
  CHECK(static_cast<double>(sn) == Approx(1).epsilon(1e-16));
  CHECK(static_cast<double>(cn) == Approx(0).margin(1e-16));
}

TEST_CASE("chains have the printed frequencies", "[study]") {
  const auto modes = [](std::vector<Wide> mass, Wide k, bool left, bool right) {
    const std::size_t n = mass.size();
    std::vector<Wide> stiffness(n * n, 0);
    for (std::size_t i = 0; i + 1 < n; ++i) {
      stiffness[i * n + i] += k, stiffness[(i + 1) * n + i + 1] += k;
      stiffness[i * n + i + 1] -= k, stiffness[(i + 1) * n + i] -= k;
    }
    if (left) stiffness[0] += k;
    if (right) stiffness[n * n - 1] += k;
    return LinearModes(stiffness, mass, std::vector<Wide>(n, 0), std::vector<Wide>(n, 0)).frequencies();
  };
  const auto check = [](Wide got, double want) { CHECK(static_cast<double>(got) == Approx(want).epsilon(1e-14)); };
  const std::vector<Wide> ten(10, 1);
  check(modes(ten, 100, true, true).front(), 2.846296765465703);
  check(modes(ten, 100, true, true).back(), 19.79642883761865);
  check(modes(ten, 100, true, false).front(), 1.494601871728485);
  check(modes(ten, 100, false, false)[1], 3.128689300804617);
  CHECK(modes(ten, 100, false, false)[0] == 0);
  check(modes({1, 1000000}, 10000, true, false).front(), 0.070710669279819435);
  check(modes({1, 1000000}, 1e8L, true, false).back(), 14142.137391498235);
  std::vector<Wide> heavy(10, 1);
  heavy.back() = 1000000;
  check(modes(heavy, 1e8L, true, false).front(), 3.16227315392887588);
  check(modes(heavy, 1e8L, true, false).back(), 19753.7668242911528);
}
