// Error norms on numbers whose answer is known.
#include "study/norms.h"
#include "support/catch.h"

using namespace feder;

TEST_CASE("distance is the root of the mean square over points", "[study]") {
  const std::vector<double> a = {0, 0, 0, 1, 1, 1}, b = {3, 0, 4, 1, 1, 1};
  CHECK(rms_distance(a, b) == Approx(5 / std::sqrt(2.0)));
  CHECK(std::isnan(rms_distance(a, std::vector<double>{1, 2, 3})));
}

TEST_CASE("angle between orientations, blind to the sign of the quaternion, exact where small", "[study]") {
  const double half = 0.5e-9;
  const std::vector<double> one = {0, 0, 0, 1}, turned = {std::sin(half), 0, 0, std::cos(half)};
  CHECK(largest_angle(turned, one) == Approx(1e-9).epsilon(1e-12));
  const std::vector<double> minus = {-turned[0], 0, 0, -turned[3]};
  CHECK(largest_angle(minus, one) == Approx(1e-9).epsilon(1e-12));
  const double s = std::sqrt(0.5);
  CHECK(largest_angle(std::vector<double>{0, s, 0, s}, one) == Approx(1.5707963267948966));
  CHECK(std::isnan(largest_angle({}, {})));
}

TEST_CASE("correct digits of the worst component", "[study]") {
  Observation run, reference;
  reference.x = {1, 0, 0}, reference.v = {0, 10, 0};
  run = reference;
  CHECK(correct_digits(run, reference, 1, 10) == 17);
  run.v[1] = 10 * (1 + 2e-3);  // 2e-3 / (1 + 1)
  run.x[1] = 1e-5;
  CHECK(correct_digits(run, reference, 1, 10) == Approx(3));
}

TEST_CASE("Hermite interpolation is exact for cubics", "[study]") {
  const auto at = [](double t) {
    Observation o;
    o.x = {1 + t - 2 * t * t + 0.5 * t * t * t, 0, t};
    o.v = {1 - 4 * t + 1.5 * t * t, 0, 1};
    return o;
  };
  Observation between;
  interpolate(1, at(1), 3, at(3), 1.7, between);
  const Observation exact = at(1.7);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(between.x[i] == Approx(exact.x[i]));
    CHECK(between.v[i] == Approx(exact.v[i]));
  }
}

TEST_CASE("a straight line is found with its residual", "[study]") {
  const std::vector<double> x = {0, 1, 2, 3}, y = {1, 3.1, 4.9, 7};
  const Line line = fit_line(x, y);
  CHECK(line.slope == Approx(1.98));
  CHECK(line.intercept == Approx(1.03));
  CHECK(line.rms == Approx(std::sqrt((0.03 * 0.03 + 0.09 * 0.09 + 0.09 * 0.09 + 0.03 * 0.03) / 4)));
  CHECK(std::isnan(fit_line(std::vector<double>{1}, std::vector<double>{1}).slope));
}
