// Formulas: values against the C library and by hand, derivatives against differences, messages with their column.
#include <cmath>

#include "base/functions.h"
#include "feder/force.h"
#include "feder/memory.h"
#include "forces/expression.h"
#include "support/catch.h"

using namespace feder;

namespace {

const std::vector<Expression::Parameter> kParameters = {{"k", 3}, {"w", 0.5}, {"tiny", 1e-3}};
const double kAt[Expression::kVariables] = {1.5, -2, 0.25, 0.5, 4, -1, 2, 10};  // x y z vx vy vz m t

double value(const char* text) {
  double out = std::nan("");
  return Expression(text, kParameters).value(kAt, out) ? out : std::nan("");
}

std::string message(const std::string& text) {
  try {
    Expression(text, kParameters);
  } catch (const SceneError& e) {
    return e.what();
  }
  return "no error";
}

}  // namespace

TEST_CASE("formulas follow the rules of precedence", "[forces][expression]") {
  CHECK(value("1 + 2*3 - 4/8") == 6.5);
  CHECK(value("-x^2") == -2.25);
  CHECK(value("2^-1") == 0.5);
  CHECK(value("2^3^2") == 512);
  CHECK(value("(1+2)*3") == 9);
  CHECK(value("8/2/2 - 1 - 1") == 0);
  CHECK(value("--x + +y") == -0.5);
  CHECK(value("1.5e2*tiny") == Approx(0.15));
  CHECK(value("-k*x - k*x^3 + 2*cos(w*t)") == Approx(-4.5 - 3 * 3.375 + 2 * std::cos(5.0)).epsilon(1e-14));
  CHECK(value("m*vx + vy/vz + z") == -2.75);
  CHECK(value("min(x, y) + 10*max(x, y) + abs(y)") == 15);
  CHECK(value("pow(x, 2.5) + sqrt(t)") == Approx(std::pow(1.5, 2.5) + std::sqrt(10.0)).epsilon(1e-14));
  CHECK(value("pow(y, 3)") == -8);
  CHECK(value("exp(-x)*log(t)*sin(pi/6)") == Approx(std::exp(-1.5) * std::log(10.0) * 0.5).epsilon(1e-14));
}

TEST_CASE("a formula that cannot be read names the column", "[forces][expression]") {
  CHECK(message("-k*xx") == "column 4 of '-k*xx': unknown name 'xx'; did you mean 'x'?");
  CHECK_THAT(message("1 +"), Catch::Contains("column 4") && Catch::Contains("got the end"));
  CHECK_THAT(message("(1 + x"), Catch::Contains("column 7") && Catch::Contains("expected ')'"));
  CHECK_THAT(message("x y"),
             Catch::Contains("column 3") && Catch::Contains("expected an operator or the end, got 'y'"));
  CHECK_THAT(message("sin x"), Catch::Contains("column 5") && Catch::Contains("expected '(' after sin"));
  CHECK_THAT(message("min(x)"), Catch::Contains("column 6") && Catch::Contains("second argument of min"));
  CHECK_THAT(message("x; os.exit()"), Catch::Contains("column 2") && Catch::Contains("got ';'"));
  CHECK_THAT(message(""), Catch::Contains("column 1"));
  CHECK_THAT(message(std::string(5000, '(')), Catch::Contains("at most 100 nested"));
  CHECK_THROWS_WITH(Expression("x", std::vector<Expression::Parameter>{{"sin", 1}}), Catch::Contains("got 'sin'"));
}

TEST_CASE("what has no value says so", "[forces][expression]") {
  for (const char* text : {"1/(x - 1.5)", "log(y)", "log(0)", "sqrt(y)", "y^0.5", "exp(1000*x)", "0^-1", "1/(1/0)"}) {
    CAPTURE(text);
    CHECK(std::isnan(value(text)));
  }
}

TEST_CASE("derivatives of formulas agree with differences", "[forces][expression]") {
  const char* const text =
      GENERATE("-k*x - k*x^3 + cos(w*t)", "x*y*z/(1 + x^2)", "exp(-x)*sin(y*z)", "sqrt(x + 9)*abs(y)", "pow(x, y)",
               "min(x*y, z)*max(x, z)", "log(x^2 + y^2)", "-vx*abs(vy) + vz^3*x", "pow(x*vy, 1.7)", "x^-2 + 2^x");
  CAPTURE(text);
  const Expression e(text, kParameters);
  for (const int first : {0, Expression::kVelocity}) {
    double slope[3];
    REQUIRE(e.gradient(kAt, first, slope));
    for (int k = 0; k < 3; ++k) {
      double at[Expression::kVariables], above = 0, below = 0;
      std::copy(std::begin(kAt), std::end(kAt), at);
      const double h = 1e-5;
      at[first + k] = kAt[first + k] + h;
      REQUIRE(e.value(at, above));
      at[first + k] = kAt[first + k] - h;
      REQUIRE(e.value(at, below));
      CHECK(slope[k] == Approx((above - below) / (2 * h)).margin(1e-7).epsilon(1e-7));
    }
  }
}

TEST_CASE("own exponential, logarithm and power keep their digits", "[base]") {
  for (double x = -700; x <= 700; x += 3.7) CHECK(exponential(x) == Approx(std::exp(x)).epsilon(2e-15));
  for (double x = 1e-300; x < 1e300; x *= 7.3)
    CHECK(natural_log(x) == Approx(std::log(x)).epsilon(2e-15).margin(2e-16));
  for (const double b : {-3.0, -0.5, 0.3, 1.0, 1.5, 2.0, 3.7, 20.0, 100.0})
    for (double a = 0.01; a < 100; a *= 1.9) CHECK(power(a, b) == Approx(std::pow(a, b)).epsilon(1e-13));
  CHECK(power(-2, 101) == Approx(std::pow(-2.0, 101)).epsilon(1e-13));
  CHECK(power(0, 2) == 0);
  CHECK(std::isnan(power(-2, 0.5)));
}

TEST_CASE("a force by formulas counts what has no value as nothing", "[forces][expression]") {
  Arena arena("test");
  Params p;
  p.set("x", std::string("-k*x^3 - 0.5*vx")), p.set("y", std::string("sqrt(y)")), p.set("k", 2.0);
  const auto f = find_variant(force_kinds(), "expression", "force kind").make(arena, p);
  p.check_all_read("force");
  MassPoint point;
  point.position = Vec3(2, -1, 0), point.velocity = Vec3(4, 0, 0), point.mass = 1;
  Vec3 out(1, 2, 3);
  f->add(&point, 1, 0, &out);
  CHECK(out == Vec3(-17, 2, 3));
  CHECK(f->faults() == 1);
  CHECK(f->depends_on_velocity());
  Mat3 k = Mat3::Zero(), d = Mat3::Zero();
  CHECK(f->derivative(&point, 1, 0, false, &k));
  CHECK(f->derivative(&point, 1, 0, true, &d));
  CHECK(k(0, 0) == Approx(-24));
  CHECK(d(0, 0) == Approx(-0.5));
  Params wrong;
  wrong.set("y", std::string("-k*x"));
  CHECK_THROWS_WITH(find_variant(force_kinds(), "expression", "force kind").make(arena, wrong),
                    Catch::Contains("y: column 2") && Catch::Contains("unknown name 'k'"));
}
