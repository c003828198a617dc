// Quadratic bending of cloth that is flat at rest: the forces of the hinges' angles to second order, and a form that
// keeps momentum, angular momentum and cloth that is moved as a whole.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/jobs.h"
#include "base/rng.h"
#include "cloth/batches.h"
#include "cloth/sheets.h"

using namespace feder;
using namespace feder::test;

namespace {

// A sheet of 7 x 5 vertices whose hinges push once, at positions `moved` from rest.
struct Bent {
  Arena arena{"bent"};
  std::vector<Vec3> rest, position;
  std::vector<Real> mass;
  std::vector<Row4> delta_position, before, velocity;
  ClothMesh mesh{arena};
  JobPool jobs;
  StepContext context;
  ClothView view;

  Bent() {
    const Real size[2] = {Real(0.6), Real(0.4)};
    std::vector<std::uint32_t> triangles;
    make_sheet(size, 7, 5, rest, triangles);
    mesh.triangles.assign(triangles.begin(), triangles.end());
    mesh.grid = 7;
    make_elements(mesh, rest, {2000, 200, Real(0.01)});
    const std::size_t points = rest.size();
    rest.push_back(Vec3(0, 0, 0));  // the spare
    position = rest;
    mass.assign(points + 1, Real(0.002));
    mass[points] = 0;
    delta_position.assign(points + 1, Row4{0, 0, 0, 500});
    delta_position[points].w = 0;
    velocity = before = delta_position;
    context.jobs = &jobs;
    view.mesh = &mesh;
    view.points = static_cast<std::uint32_t>(points), view.total = view.points + 1;
    view.version = 1;
    view.position = position.data(), view.rest = rest.data(), view.mass = mass.data();
    view.delta_position = delta_position.data(), view.before = before.data(), view.velocity = velocity.data();
  }

  // Impulses of a push over 1 s, N s.
  std::vector<Vec3> push(bool quadratic) {
    for (Row4& u : velocity) u.set(Vec3(0, 0, 0));
    ClothBatches batches(arena, quadratic);
    batches.build(view);
    batches.current_position(view, jobs);
    batches.bend(view, Real(1e-4), context);
    std::vector<Vec3> out(view.points);
    for (std::uint32_t i = 0; i < view.points; ++i) out[i] = Real(1e4) * mass[i] * velocity[i].vec();
    return out;
  }
};

Real size_of(const std::vector<Vec3>& list) {
  Real most = 0;
  for (const Vec3& f : list) most = std::max(most, length(f));
  return most;
}

}  // namespace

TEST_CASE("quadratic bending pushes as the angles of hinges do, wherever the cloth has moved", "[cloth]") {
  const bool at_start = GENERATE(true, false);
  Bent sheet;
  // out of its plane by a six-hundredth of its size, all of it turned and moved away
  const Quat turn = from_axis_angle(Vec3(1, 2, 3), Real(1.1));
  for (std::uint32_t i = 0; i < sheet.view.points; ++i) {
    const Vec3 x = sheet.rest[i];
    const Real high = Real(0.001) * std::sin(9 * x[0] + 4 * x[2]) * std::cos(7 * x[2]);
    const Vec3 now = rotate(turn, Vec3(x + Vec3(0, high, 0))) + Vec3(2, -1, 3);
    if (at_start)
      sheet.position[i] = now;
    else
      sheet.delta_position[i].set(now - x);
  }
  const std::vector<Vec3> form = sheet.push(true), angles = sheet.push(false);
  REQUIRE(size_of(angles) > Real(1e-4));
  Real worst = 0;
  for (std::size_t i = 0; i < form.size(); ++i) worst = std::max(worst, length(Vec3(form[i] - angles[i])));
  CHECK(worst < Real(0.02) * size_of(angles));
}

TEST_CASE("quadratic bending has no sum of forces or torques, and none for a sheet that is flat", "[cloth]") {
  Bent sheet;
  Rng random(7);
  for (std::uint32_t i = 0; i < sheet.view.points; ++i) {
    Vec3 d;
    for (int k = 0; k < 3; ++k) d[k] = random.uniform(Real(-0.3), Real(0.3));
    sheet.delta_position[i].set(d);
  }
  const std::vector<Vec3> f = sheet.push(true);
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  for (std::uint32_t i = 0; i < sheet.view.points; ++i) {
    force += f[i];
    torque += cross(Vec3(sheet.rest[i] + sheet.delta_position[i].vec()), f[i]);
  }
  const Real digit = std::numeric_limits<Real>::epsilon() * 100;
  CHECK(length(force) < digit * size_of(f));
  CHECK(length(torque) < digit * size_of(f));
  for (std::uint32_t i = 0; i < sheet.view.points; ++i) sheet.delta_position[i].set(Vec3(1, 2, 3));
  CHECK(size_of(sheet.push(true)) < digit * size_of(f));
}
