// Points in tetrahedra: by barycentric weights and by the sides of the faces, against each other and against how the
// points were made.
#include <limits>

#include "base/rng.h"
#include "geom/tetrahedron.h"
#include "support/catch.h"

namespace feder::test {
namespace {

enum class Form { fat, far, sliver, needle, flat, turned };

Double3 random_point(Rng& rng, double size) {
  return {size * (2 * rng.unit() - 1), size * (2 * rng.unit() - 1), size * (2 * rng.unit() - 1)};
}

// Slivers: four points near a circle; needles: three of them near one place; flat: one just above the face across.
Corners random_tetrahedron(Rng& rng, Form form) {
  Corners x = {random_point(rng, 1), random_point(rng, 1), random_point(rng, 1), random_point(rng, 1)};
  const double thin = 1e-4;
  if (form == Form::sliver)
    for (std::size_t k = 0; k < 4; ++k) {
      const double angle = 1.5708 * (static_cast<double>(k) + 0.3 * rng.unit());
      x[k] = {std::cos(angle), std::sin(angle), thin * rng.unit()};
    }
  if (form == Form::needle)
    for (const std::size_t k : {std::size_t(2), std::size_t(3)}) x[k] = x[1] + random_point(rng, thin);
  if (form == Form::flat) x[3] = 0.3 * x[0] + 0.4 * x[1] + 0.3 * x[2] + thin * cross(x[1] - x[0], x[2] - x[0]);
  const bool want_turned = form == Form::turned;
  if ((tetrahedron_volume(x) < 0) != want_turned) std::swap(x[0], x[1]);
  if (form == Form::far)
    for (Double3& p : x) p = p + Double3{1000, -2000, 500};
  return x;
}

Double3 at_weights(const Corners& x, const std::array<double, 4>& w) {
  return w[0] * x[0] + w[1] * x[1] + w[2] * x[2] + w[3] * x[3];
}

// m: from the nearest of the four planes.
double from_planes(const Corners& x, const Double3& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& f : kTetrahedronFaces) {
    const Double3 &a = x[std::size_t(f[0])], &b = x[std::size_t(f[1])], &c = x[std::size_t(f[2])];
    const Double3 n = cross(b - a, c - a);
    least = std::fmin(least, std::fabs(dot(n, p - a)) / length(n));
  }
  return least;
}

Form any_form() { return GENERATE(Form::fat, Form::far, Form::sliver, Form::needle, Form::flat, Form::turned); }

}  // namespace

TEST_CASE("weights and faces agree on what is in a tetrahedron, outside 1e-7 of its size", "[geom]") {
  const Form form = any_form();
  Rng rng(31);
  int inside = 0, close = 0, wrong = 0;
  for (int n = 0; n < 20000; ++n) {
    const Corners x = random_tetrahedron(rng, form);
    std::array<double, 4> w{};
    double sum = 0;
    for (double& k : w) k = rng.unit() - (n % 2 == 0 ? 0.25 : 0.0), sum += k;  // half of them within
    if (std::fabs(sum) < 0.1) continue;
    for (double& k : w) k /= sum;
    // some at faces, edges and corners
    if (n % 5 == 0) w[1] += w[0], w[0] = 0;
    if (n % 10 == 0) w[2] += w[1], w[1] = 0;
    if (n % 20 == 0) w[3] += w[2], w[2] = 0;
    const Double3 p = at_weights(x, w);
    const bool by_weights = within_by_weights(x, p), by_faces = within_by_faces(x, p);
    if (from_planes(x, p) <= 1e-7 * longest_edge(x)) {
      ++close;
      continue;
    }
    bool made_inside = true;
    for (const double k : w) made_inside = made_inside && k > 0;
    wrong += by_weights != by_faces || by_weights != made_inside;
    inside += by_weights;
  }
  CAPTURE(int(form), inside, close);
  CHECK(wrong == 0);
  CHECK(inside > 5000);
  CHECK(close >= 3900);  // those at faces, edges and corners
}

TEST_CASE("weights add up to one and bring the point back", "[geom]") {
  const Form form = any_form();
  Rng rng(32);
  double worst = 0, worst_sum = 0;
  for (int n = 0; n < 2000; ++n) {
    const Corners x = random_tetrahedron(rng, form);
    const Double3 p = x[0] + random_point(rng, 2);
    const std::array<double, 4> w = barycentric(x, p);
    double size = 1;
    for (const double k : w) size = std::fmax(size, std::fabs(k));
    worst_sum = std::fmax(worst_sum, std::fabs(w[0] + w[1] + w[2] + w[3] - 1) / size);
    worst = std::fmax(worst, length(at_weights(x, w) - p) / (size * longest_edge(x)));
  }
  CAPTURE(int(form));
  CHECK(worst_sum < 1e-14);
  CHECK(worst < 1e-7);
}

TEST_CASE("corners and edges and faces belong to a tetrahedron and nothing to one without volume", "[geom]") {
  // of whole numbers, so that nothing is rounded
  const Corners x = {{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {0, 0, 4}}};
  for (const Double3& p : {x[0], x[1], x[2], x[3], Double3{2, 0, 0}, Double3{2, 2, 0}, Double3{1, 1, 0},
                           Double3{1, 1, 2}, Double3{1, 1, 1}}) {
    CHECK(within_by_weights(x, p));
    CHECK(within_by_faces(x, p));
  }
  for (const Double3& p : {Double3{-1, 1, 1}, Double3{2, 2, 1}, Double3{4, 4, 4}, Double3{5, 0, 0},
                           Double3{std::numeric_limits<double>::quiet_NaN(), 1, 1}}) {
    CHECK_FALSE(within_by_weights(x, p));
    CHECK_FALSE(within_by_faces(x, p));
  }
  const Corners flat = {{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {4, 4, 0}}};
  for (const Double3& p : {Double3{1, 1, 0}, Double3{0, 0, 0}}) {
    CHECK_FALSE(within_by_weights(flat, p));
    CHECK_FALSE(within_by_faces(flat, p));
  }
}

}  // namespace feder::test
