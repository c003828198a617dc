// Stability limits: what info() predicts against the matrix of one actual step, for every registered
// method, and against the published numbers.
#include "integrate/limits.h"
#include "support/catch.h"

using namespace feder;

namespace {

void check_limit(double observed, double wanted, double relative) {
  CAPTURE(observed, wanted);
  if (std::isinf(wanted))
    CHECK(std::isinf(observed));
  else
    CHECK(std::fabs(observed - wanted) <= relative * wanted);
}

}  // namespace

TEST_CASE("integrators have their stated stability limits", "[integrate][contract]") {
  const int row = GENERATE(range(0, static_cast<int>(integrators().size())));
  const double zeta = GENERATE(0.0, 0.01, 0.1, 0.5, 1.0, 2.0, 5.0);
  const auto& method = integrators()[static_cast<std::size_t>(row)];
  Arena arena("test");
  const IntegratorInfo info = method.make(arena, Params())->info();
  const double wanted = predicted_limit(info, zeta);
  CAPTURE(method.name, zeta);
  REQUIRE_FALSE(std::isnan(wanted));
  check_limit(observed_limit(method, Params(), zeta), wanted, 1e-6);
}

TEST_CASE("stability limits at several damping ratios", "[integrate]") {
  struct Row {
    const char *method, *option, *value;
    double zeta, limit, precision;  // as many digits as are known
  };
  static const Row kRows[] = {{"midpoint", "", "", 0.01, 0.444, 1e-3},
                              {"heun", "", "", 0.1, 1.050, 1e-3},
                              {"rk2", "", "", 0.5, 2, 1e-6},
                              {"rk2", "", "", 1, 2, 1e-6},
                              {"rk4", "", "", 0, 2.8284, 1e-4},
                              {"rk4", "", "", 0.1, 2.951, 1e-3},
                              {"rk4", "", "", 0.5, 2.623, 1e-3},
                              {"rk4", "", "", 1, 2.7853, 1e-4},
                              {"rk45", "", "", 0, 0.997, 1e-3},
                              {"rk45", "", "", 0.1, 2.68, 1e-2},
                              {"rk45", "", "", 1, 3.3066, 1e-4},
                              {"yoshida4", "", "", 0, 1.5734, 1e-4},
                              {"yoshida4", "damping", "explicit", 1, 1.108, 1e-3},
                              {"symplectic_euler", "damping", "explicit", 0.1, 1.810, 1e-3},
                              {"symplectic_euler", "damping", "explicit", 1, 0.828427124746, 1e-6},
                              {"symplectic_euler", "damping", "explicit", 5, 0.198, 1e-3},
                              {"symplectic_euler", "damping", "implicit", 0.1, 2.210, 1e-3},
                              {"symplectic_euler", "damping", "implicit", 1, 4.828427124746, 1e-6},
                              {"symplectic_euler", "", "", 5, 20.2, 1e-2}};
  for (const Row& r : kRows) {
    CAPTURE(r.method, r.option, r.zeta);
    Params p;
    if (*r.option) p.set(r.option, std::string(r.value));
    check_limit(observed_limit(find_variant(integrators(), r.method, "integrator"), p, r.zeta), r.limit, r.precision);
  }
}

TEST_CASE("amplitude kept per step", "[integrate]") {
  struct Row {
    const char* method;
    double z, amplitude, margin;
  };
  static const Row kRows[] = {{"implicit_euler", 1, 0.70710678, 1e-6},
                              {"implicit_euler", 10, 0.0995037, 1e-6},
                              {"implicit_midpoint", 10, 1, 1e-6},
                              {"tr_bdf2", 1, 0.9969, 1e-4},
                              {"ros2", 1, 0.9969, 1e-4},
                              {"tr_bdf2", 10, 0.445, 1e-3},
                              {"ros2", 100, 0.048, 1e-3}};
  for (const Row& r : kRows) {
    CAPTURE(r.method, r.z);
    Arena arena("test");
    const auto m = find_variant(integrators(), r.method, "integrator").make(arena, Params());
    CHECK(step_matrix(*m, r.z, 0).spectral_radius() == Approx(r.amplitude).margin(r.margin));
  }
}
