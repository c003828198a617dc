// Every registered kernel: integral, derivatives, support; and its sums over neighbours against plain sums.
#include <cmath>
#include <vector>

#include "base/rng.h"
#include "feder/types.h"
#include "sph/boundary_table.h"
#include "sph/kernel.h"
#include "support/catch.h"

using namespace feder;

namespace {

const Kernel& row() {
  const int k = GENERATE(range(0, static_cast<int>(kernels().size())));
  return kernels()[static_cast<std::size_t>(k)];
}

double ring(int d, double u) { return d == 3 ? 4 * M_PI * u * u : 2 * M_PI * u; }

// Every distinct shape of the row that has a value.
std::vector<KernelShape> shapes(const Kernel& k) {
  std::vector<KernelShape> list;
  for (const KernelShape& s : {k.density, k.gradient, k.viscosity})
    if (s.value) list.push_back(s);
  return list;
}

}  // namespace

TEST_CASE("kernels integrate to one and end at their support", "[sph][contract]") {
  const Kernel& k = row();
  const int d = GENERATE(2, 3);
  CAPTURE(k.name, d);
  for (const KernelShape& s : shapes(k)) {
    double sum = 0;
    const int n = 200000;
    for (int i = 0; i < n; ++i) {
      const double u = (i + 0.5) / n;
      sum += s.value(d, u) * ring(d, u) / n;
    }
    CHECK(sum == Approx(1).epsilon(1e-6));
    CHECK(s.value(d, 0.999) >= 0);
    CHECK(s.value(d, 0.9999) == Approx(0).margin(1e-5));
    for (const double u : {1.0, 1.5, 40.0}) {
      CHECK(s.value(d, u) == 0);
      CHECK(s.slope(d, u) == 0);
      CHECK(s.laplacian(d, u) == 0);
    }
  }
}

TEST_CASE("slope and Laplacian are the kernel's derivatives", "[sph][contract]") {
  const Kernel& k = row();
  const int d = GENERATE(2, 3);
  CAPTURE(k.name, d);
  const double e = 1e-4;
  for (const KernelShape& s : shapes(k)) {
    for (double u = 0.013; u < 0.99; u += 0.0217) {
      CAPTURE(u);
      const double below = s.value(d, u - e), at = s.value(d, u), above = s.value(d, u + e);
      const double first = (above - below) / (2 * e), second = (above - 2 * at + below) / (e * e);
      const double scale = std::abs(at) / (u * u) + 10;
      CHECK(s.slope(d, u) * u == Approx(first).margin(1e-5 * scale / u));
      if (std::abs(u - 0.5) < 2 * e) continue;  // the cubic spline's third derivative jumps
      CHECK(s.laplacian(d, u) == Approx(second + (d - 1) / u * first).margin(1e-4 * scale));
      if (s.second) CHECK(s.second(d, u) == Approx(second).margin(1e-4 * scale));
    }
  }
}

TEST_CASE("the sum over a lattice is nearly one", "[sph][contract]") {
  const Kernel& k = row();
  const int d = GENERATE(2, 3);
  if (!k.sweeps) return;
  CAPTURE(k.name, d);
  const double support = k.support[d - 2];
  double sum = 0;
  const int n = 4;
  for (int x = -n; x <= n; ++x)
    for (int y = -n; y <= n; ++y)
      for (int z = d == 3 ? -n : 0; z <= (d == 3 ? n : 0); ++z)
        sum += k.density.value(d, std::sqrt(double(x * x + y * y + z * z)) / support) / std::pow(support, d);
  CHECK(sum == Approx(1).epsilon(0.03));
}

TEST_CASE("published sums of the cubic spline over a lattice", "[sph]") {
  for (const Kernel& k : kernels()) {
    if (std::string(k.name) != "cubic") continue;
    const struct {
      int d;
      double h, sum;
    } rows[] = {{3, 1.0, 0.99997}, {3, 1.2, 1.00081}, {3, 1.3, 0.99726},
                {2, 1.0, 1.00086}, {2, 1.2, 0.99976}, {2, 1.3, 0.99995}};
    for (const auto& r : rows) {
      double sum = 0;
      for (int x = -4; x <= 4; ++x)
        for (int y = -4; y <= 4; ++y)
          for (int z = r.d == 3 ? -4 : 0; z <= (r.d == 3 ? 4 : 0); ++z)
            sum += k.density.value(r.d, std::sqrt(double(x * x + y * y + z * z)) / (2 * r.h)) / std::pow(2 * r.h, r.d);
      CHECK(sum == Approx(r.sum).margin(6e-6));
    }
  }
}

TEST_CASE("a lattice beside a wall is at rest: density and force of the first layer", "[sph][contract]") {
  const Kernel& k = row();
  const int d = GENERATE(2, 3);
  if (!k.sweeps) return;
  CAPTURE(k.name, d);
  const double support = k.support[d - 2];
  const LatticeSums l = lattice_sums(k, d, support);
  const BoundaryTable table(k, d, support);
  const auto at = [&](double spacings) { return table.at(WideReal(spacings / support)); };
  CHECK((l.whole - l.missing) / l.whole + at(0.5).value == Approx(1).margin(2e-3));
  // pressure on both sides of a pair, on one side at the wall
  CHECK(at(0.5).slope / support == Approx(-2 * l.missing_slope / l.whole).epsilon(2e-3));
  CHECK(at(1.5).value < 0.02);
  CHECK(table.at(1).value == Approx(0).margin(1e-6));
  CHECK(table.at(3).slope == 0);
  CHECK(table.at(0).share == Approx(0.5).margin(1e-3));
  CHECK(table.at(-1).share == Approx(1).margin(2e-3));
  CHECK(table.at(1).share == 0);
  CHECK(table.at(0).colour > table.at(WideReal(0.5)).colour);
  // the air beyond a free surface follows from the slope of the kernel's share in it
  for (const double s : {0.0, 0.1, 0.3, 0.5, 0.7, 0.9})
    CHECK(table.air(table.at(WideReal(s)).colour) == Approx(table.at(WideReal(s)).share).margin(2e-3));
  CHECK(table.air(0) == 0);
  CHECK(table.air(2 * table.at(0).colour) == Approx(0.5).margin(1e-3));
  for (double s = -0.95; s < 0.95; s += 0.0313) {
    const double e = 1.0 / 128, fall = (table.at(WideReal(s - e)).value - table.at(WideReal(s + e)).value) / (2 * e);
    CHECK(table.at(WideReal(s)).slope == Approx(fall).epsilon(0.02).margin(0.02));
    CHECK(table.at(WideReal(s - e)).value >= table.at(WideReal(s + e)).value);
  }
}

// The sweeps, plain and wide, against sums written down from the shapes.
TEST_CASE("sums over neighbours equal plain sums, and the wide ones bit for bit", "[sph][contract]") {
  const Kernel& k = row();
  if (!k.sweeps) return;
  CAPTURE(k.name);
  constexpr unsigned n = 60, stride = 64;
  Rng rng(8);
  std::vector<WideReal> points(4 * (n + 1)), velocity(4 * (n + 1));
  for (unsigned i = 0; i < n; ++i)
    for (unsigned c = 0; c < 4; ++c) {
      points[4 * i + c] = WideReal(rng.uniform(0, 1));
      velocity[4 * i + c] = WideReal(rng.uniform(-1, 1));
    }
  points[4 * n] = WideReal(1e9);
  std::vector<unsigned> neighbors(n * stride, n), rounded(n);
  for (unsigned i = 0; i < n; ++i) {
    unsigned m = 0;
    for (unsigned j = 0; j < n; ++j)
      if (j != i && (i + j) % 5 != 0) neighbors[i * stride + m++] = j;  // no multiple of eight
    rounded[i] = (m + 7) / 8 * 8;
  }
  SweepInput in;
  in.points = points.data(), in.velocity = velocity.data(), in.neighbors = neighbors.data(),
  in.rounded = rounded.data();
  in.stride = stride, in.inv_support = WideReal(1.25), in.soft = WideReal(1e-3), in.damping = WideReal(0.3);

  const auto run = [&](const Sweeps& s) {
    std::vector<std::vector<WideReal>> out;
    std::vector<WideReal> one(n), four(4 * n);
    s.values(in, 0, n, one.data()), out.push_back(one);
    s.slopes(in, 0, n, four.data(), one.data()), out.push_back(four), out.push_back(one);
    s.push(in, 0, n, four.data()), out.push_back(four);
    s.push_damped(in, 0, n, four.data()), out.push_back(four);
    s.viscous(in, 0, n, four.data()), out.push_back(four);
    s.cohere(in, 0, n, four.data()), out.push_back(four);
    s.push_from(in, 0, n, four.data()), out.push_back(four);
    s.growth(in, 0, n, one.data()), out.push_back(one);
    s.curl(in, 0, n, four.data()), out.push_back(four);
    s.climb(in, 0, n, four.data()), out.push_back(four);
    s.colors(in, 0, n, one.data()), out.push_back(one);
    s.draw(in, 0, n, four.data()), out.push_back(four);
    s.values_by(in, 0, n, one.data()), out.push_back(one);
    s.colors_by(in, 0, n, one.data()), out.push_back(one);
    s.draw_by(in, 0, n, four.data()), out.push_back(four);
    return out;
  };
  const auto plain = run(*k.sweeps);
  CHECK(run(sweeps_of(k)) == plain);

  const double nd = k.norm_density[1], ng = k.norm_gradient[1];
  double momentum[3] = {0, 0, 0};
  for (unsigned i = 0; i < n; ++i) {
    double value = 0, slope[3] = {}, square = 0, push[3] = {}, growth = 0;
    for (unsigned m = 0; m < rounded[i]; ++m) {
      const unsigned j = neighbors[i * stride + m];
      if (j == n) continue;
      double x[3], r2 = 0;
      for (unsigned c = 0; c < 3; ++c) x[c] = double(points[4 * i + c]) - points[4 * j + c], r2 += x[c] * x[c];
      const double u = std::sqrt(r2) * 1.25, g = k.gradient.slope(3, u) / ng;
      value += k.density.value(3, u) / nd;
      square += g * g * u * u;
      for (unsigned c = 0; c < 3; ++c) {
        slope[c] += g * x[c];
        growth += g * x[c] * (double(velocity[4 * i + c]) - velocity[4 * j + c]);
        push[c] += g * x[c] * (points[4 * i + 3] + points[4 * j + 3]);
      }
    }
    CHECK(plain[0][i] == Approx(value).epsilon(1e-4));
    CHECK(plain[1][4 * i + 3] == Approx(value).epsilon(1e-4));
    CHECK(plain[2][i] == Approx(square).epsilon(1e-4));
    CHECK(plain[8][i] == Approx(growth).margin(2e-3));
    for (unsigned c = 0; c < 3; ++c) {
      CHECK(plain[1][4 * i + c] == Approx(slope[c]).margin(2e-3));
      CHECK(plain[3][4 * i + c] == Approx(push[c]).margin(2e-3));
      momentum[c] += plain[3][4 * i + c];
    }
  }
  for (const double m : momentum) CHECK(m == Approx(0).margin(1e-2));
}
