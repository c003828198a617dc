// Boundaries hold whatever they do: thin vessels that are shaken, tipped and thrown, solids of every kind that move and
// spin through water at random.
#include <cmath>

#include "base/rng.h"
#include "fluid/any_solver.h"
#include "fluid/tank.h"
#include "support/catch.h"

using namespace feder;

namespace {

// A closed cup of six plates, one spacing thick, two thirds full: the lid makes plain what is outside.
struct Cup {
  Cup(const std::string& solver, BodyType type, Real inside, const Vec3& at)
      : w(fluid_world(), fluid_catalog()), half(inside / 2) {
    std::vector<CompoundPart> parts;
    const Real spacing = inside / 6, out = inside + 2 * spacing;
    for (int axis = 0; axis < 3; ++axis)
      for (const Real side : {Real(-1), Real(1)}) {
        Vec3 size = vec3(out, out, out), middle = Vec3::Zero();
        size[axis] = spacing, middle[axis] = side * (inside + spacing) / 2;
        parts.push_back({make_box(size[0], size[1], size[2]), {middle, Quat{}}});
      }
    BodyDesc b;
    b.type = type, b.shape = make_compound(parts), b.density = 500, b.position = at;
    body = w.need<Rigid>().add_body(b);
    FluidDesc d;
    d.solver = solver, d.spacing = spacing;
    water = add_water(w, d, vec3(inside, inside * 2 / 3, inside), at - vec3(half, half, half));
    all = places(w, water).size();
  }
  // The farthest from the middle of the cup along one of its axes, over what is allowed; 2 if some have been lost.
  double farthest() {
    const Pose now = w.need<Rigid>().pose(body);
    Real most = 0;
    const std::vector<Vec3> x = places(w, water);
    for (const Vec3& p : x) most = std::max(most, to_local(now, p).cwiseAbs().maxCoeff());
    return x.size() == all ? static_cast<double>(most / half) : 2.0;
  }

  World w;
  Real half;
  ObjectId body, water;
  std::size_t all = 0;
};

constexpr double kInside = 1 + 1e-4;  // rounding

}  // namespace

TEST_CASE("a cup one spacing thick, shaken and tipped over, keeps its water", "[fluid][leak]") {
  const std::string solver = any_fluid_solver();
  CAPTURE(solver);
  const Real inside = GENERATE(Real(0.04), Real(0.4));
  CAPTURE(inside);
  Cup cup(solver, BodyType::kinematic, inside, Vec3::Zero());
  const int steps = kLarge && !kAsserts ? (inside > Real(0.1) ? 120 : 40) : 15;
  for (int k = 0; k < steps; ++k) {
    const double t = (k + 1) / 60.0;
    Pose p;  // 3 m/s along a slanted line, over once a second, about an axis that turns
    p.position = vec3(Real(0.16 * std::sin(19 * t)), Real(0.1 * std::sin(23 * t)), Real(0.05 * std::sin(31 * t)));
    p.rotation = normalized(from_axis_angle(vec3(0, 1, 0), Real(0.7 * t)) *
                            from_axis_angle(vec3(0, 0, 1), Real(6.28 * t * t / (t + 1))));
    cup.w.need<Rigid>().move_to(cup.body, p);
    cup.w.step();
    CAPTURE(k);
    REQUIRE(cup.farthest() < kInside);
  }
  CHECK(cup.w.is_finite());
}

TEST_CASE("a cup one spacing thick that is thrown and tumbles on the floor keeps its water", "[fluid][leak]") {
  const std::string solver = any_fluid_solver();
  CAPTURE(solver);
  const Real inside = GENERATE(Real(0.04), Real(0.4));
  CAPTURE(inside);
  Cup cup(solver, BodyType::dynamic, inside, vec3(0, Real(0.6), 0));
  add_plane(cup.w, vec3(0, 1, 0), 0);
  cup.w.need<Rigid>().set_velocity(cup.body, vec3(3, -9, 1));
  cup.w.need<Rigid>().set_angular_velocity(cup.body, vec3(4, 2, -12));
  const int steps = kLarge && !kAsserts ? (inside > Real(0.1) ? 100 : 30) : 15;
  for (int k = 0; k < steps; ++k) {
    cup.w.step();
    CAPTURE(k);
    REQUIRE(cup.farthest() < kInside);
  }
  CHECK(cup.w.is_finite());
}

namespace {

enum class Mover { sphere, box, plate, capsule, cylinder, cone, hull, mesh, sheet, floor, count };

// A closed box of planes with water, and kinematic solids that move through it at random, fast, and no nearer to each
// other and the walls than a spacing or two: what is between them has room.
class Stir {
 public:
  static constexpr Real kSize = Real(0.8), kSpacing = Real(0.05), kFloorRise = Real(0.12);
  static constexpr int kChange = 8;  // steps between changes of velocity

  Stir(const std::string& solver, std::uint64_t seed) : w(one_substep(), fluid_catalog()), rng_(seed) {
    w.need<Rigid>();
    add_tank(w, vec3(kSize, kSize, kSize));
    add_plane(w, vec3(0, -1, 0), -kSize);
    // two in halves of their own
    for (int k = 0; k < 2; ++k)
      add(static_cast<Mover>((seed + static_cast<std::uint64_t>(5 * k)) % static_cast<std::uint64_t>(Mover::count)), k);
    FluidDesc d;
    d.solver = solver, d.spacing = kSpacing;
    water = add_water(w, d, vec3(kSize, kSize * Real(0.45), kSize), vec3(0, kFloorRise / 2, 0));
    count = places(w, water).size();
  }
  // One step; says what is wrong after it.
  std::string step() {
    for (Solid& s : solids_) move(s);
    w.step();
    std::string wrong;
    places_.clear();
    w.need<Fluid>().positions(water, places_);
    if (places_.size() != count) wrong = "particles are lost";
    for (Solid& s : solids_) check(s, wrong);
    for (const Vec3& x : places_)
      if (x.minCoeff() < -kRounding || x.maxCoeff() > kSize + kRounding) wrong = "through the box";
    return wrong;
  }

  World w;
  ObjectId water;
  std::size_t count = 0;

 private:
  static constexpr Real kRounding = Real(2e-5);  // m
  struct Solid {
    Mover kind = Mover::sphere;
    ObjectId body;
    ShapePtr solid;  // whose inside counts; null: a sheet
    Pose pose;
    Vec3 low, high;  // of its middle
    Vec3 velocity = Vec3::Zero(), angular_velocity = Vec3::Zero();
    Real half = 0;          // of a sheet
    std::vector<Vec3> was;  // a sheet's: the particles, in its frame
    int age = 0;
  };

  void add(Mover kind, int k) {
    Solid s;
    s.kind = kind;
    const Real r = rng_.uniform(Real(0.07), Real(0.11));  // around the middle
    BodyDesc b;
    b.type = BodyType::kinematic;
    switch (kind) {
      case Mover::sphere: b.shape = make_sphere(r); break;
      case Mover::box: b.shape = make_box(r, Real(1.2) * r, Real(1.1) * r); break;
      case Mover::plate: b.shape = make_box(Real(1.4) * r, Real(0.01), Real(1.4) * r); break;
      case Mover::capsule: b.shape = make_capsule(Real(0.3) * r, Real(1.4) * r); break;
      case Mover::cylinder: b.shape = make_cylinder(Real(0.5) * r, Real(1.6) * r); break;
      case Mover::cone: b.shape = make_cone(Real(0.6) * r, r); break;
      case Mover::hull: b.shape = make_hull(corners(r, 9)); break;
      case Mover::mesh: b.shape = mesh_of_box(r, Real(1.2) * r, Real(1.1) * r); break;
      case Mover::sheet: b.shape = sheet(s.half = Real(0.7) * r); break;
      default: b.shape = make_plane(vec3(0, 1, 0), 0); break;
    }
    s.solid = b.shape;
    if (kind == Mover::mesh) s.solid = make_box(r, Real(1.2) * r, Real(1.1) * r);
    if (kind == Mover::sheet) s.solid = nullptr;
    const Real margin = r + 2 * kSpacing, middle = kSize / 2;
    s.low = vec3(k == 0 ? margin : middle + r + kSpacing, margin + kFloorRise, margin);
    s.high = vec3(k == 0 ? middle - r - kSpacing : kSize - margin, kSize - margin, kSize - margin);
    if (kind == Mover::floor) s.low = Vec3::Zero(), s.high = vec3(0, kFloorRise, 0);
    s.pose.position = kind == Mover::floor ? s.low : Vec3((s.low + s.high) / 2);
    b.position = s.pose.position;
    s.body = w.need<Rigid>().add_body(b);
    solids_.push_back(s);
  }
  std::vector<Vec3> corners(Real r, int n) {
    std::vector<Vec3> points;
    while (static_cast<int>(points.size()) < n) points.push_back(r * normalized_or(random(1), vec3(0, 1, 0)));
    return points;
  }
  static ShapePtr sheet(Real half) {
    const Vec3 points[4] = {vec3(-half, 0, -half), vec3(half, 0, -half), vec3(half, 0, half), vec3(-half, 0, half)};
    const std::uint32_t triangles[6] = {0, 2, 1, 0, 3, 2};
    return make_mesh(points, triangles);
  }
  static ShapePtr mesh_of_box(Real width, Real height, Real depth) {
    std::vector<Vec3> points;
    for (int k = 0; k < 8; ++k)
      points.push_back(vec3(k & 1 ? width : -width, k & 2 ? height : -height, k & 4 ? depth : -depth) / 2);
    const std::uint32_t triangles[36] = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                         2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
    return make_mesh(points, triangles);
  }
  Vec3 random(Real most) {
    const Real x = rng_.uniform(-most, most), y = rng_.uniform(-most, most), z = rng_.uniform(-most, most);
    return vec3(x, y, z);
  }
  void move(Solid& s) {
    const Real h = static_cast<Real>(w.desc().dt);
    if (s.age++ % kChange == 0) {
      const bool floor = s.kind == Mover::floor;
      s.velocity = random(floor ? 3 : 8);
      s.angular_velocity = floor ? Vec3::Zero() : random(25);
      if (floor) s.velocity[0] = s.velocity[2] = 0;
    }
    for (int k = 0; k < 3; ++k) {
      const Real next = s.pose.position[k] + h * s.velocity[k];
      if (next < s.low[k] || next > s.high[k]) s.velocity[k] = -s.velocity[k];
    }
    s.pose.position = (s.pose.position + h * s.velocity).cwiseMax(s.low).cwiseMin(s.high);
    s.pose.rotation = integrate_rotation(s.pose.rotation, h * s.angular_velocity);
    w.need<Rigid>().move_to(s.body, s.pose);
  }
  void check(Solid& s, std::string& wrong) {
    const Pose now = w.need<Rigid>().pose(s.body);
    if (s.solid) {
      const Aabb box = s.solid->bounds(now);
      for (const Vec3& x : places_) {
        Vec3 n;
        if (!overlaps(box, Aabb{x, x}) || s.solid->distance(to_local(now, x), kSpacing, n) >= -kRounding) continue;
        wrong = "inside number " + std::to_string(static_cast<int>(s.kind));
      }
      return;
    }
    // through a sheet: its side changes where its path, straight in its frame, meets it well within its edges
    std::vector<Vec3> is;
    for (const Vec3& x : places_) is.push_back(to_local(now, x));
    for (std::size_t i = 0; i < s.was.size() && i < is.size(); ++i) {
      const Vec3 a = s.was[i], b = is[i];
      if (a[1] * b[1] >= 0) continue;
      const Vec3 at = a + a[1] / (a[1] - b[1]) * (b - a);
      if (std::max(std::abs(at[0]), std::abs(at[2])) < Real(0.9) * s.half) wrong = "through a sheet";
    }
    s.was = is;
  }

  std::vector<Solid> solids_;
  std::vector<Vec3> places_;
  Rng rng_;
};

// Particle-steps, and the first that is wrong.
void stir(const std::string& solver, double particle_steps, std::uint64_t first_seed) {
  constexpr int kSteps = 120;
  double done = 0;
  for (std::uint64_t seed = first_seed; done < particle_steps; ++seed) {
    Stir s(solver, seed);
    for (int k = 0; k < kSteps && done < particle_steps; ++k) {
      const std::string wrong = s.step();
      CAPTURE(solver, seed, k, done);
      REQUIRE(wrong == "");
      done += static_cast<double>(s.count);
    }
    REQUIRE(s.w.is_finite());
  }
}

}  // namespace

TEST_CASE("solids of every kind stir water in a closed box, and none of it enters them or leaves", "[fluid][leak]") {
  const std::string solver = any_fluid_solver();
  const double whole = solver == "pbf" ? 6e5 : 2e5;  // a million in all, by what they cost
  stir(solver, kLarge && !kAsserts ? whole : whole / 20, 1);
}

TEST_CASE("solids of every kind stir water for a hundred million particle-steps", "[fluid][.][map]") {
  const std::string solver = any_fluid_solver();
  stir(solver, solver == "pbf" ? 5e7 : 2.5e7, 1000);
}
