// Stability maps of cloth, by solver: a sheet hung by its border with a body at the other, a sheet that falls on a
// ball, and a sail pinned beside, on and inside shapes. Nobody gives solver substeps: the library chooses them, and
// says in a warning where its cap ends that (then a wrong answer comes with that warning as the entity).
#include <algorithm>
#include <cmath>

#include "study/cloth_scene.h"
#include "study/stability_problem.h"

namespace feder {
namespace {

constexpr double kGravity = 9.81;
constexpr int kPoints = 11;

struct ClothCell {
  std::unique_ptr<World> world;
  HungSheet sheet;
  double seconds = 2;
  double energy = 1;  // J, scale
  double length = 1;  // m, that the cloth may reach
  // Of the end state, by the length; NaN: not known.
  double (*error)(ClothCell&) = nullptr;
  double expected = NAN;
  double most_work = 0, mean_work = 0;  // row updates of a step
  ShapePtr shape;                       // that must keep free vertices out
};

std::unique_ptr<World> make_world(double rate, int substeps = 4) {
  return std::make_unique<World>(awake_world(kGravity, 1 / rate, substeps), cloth_catalog());
}

// A bar of `y` times the mass of the sheet at its lower border; x = stretch stiffness; `iterations` in each substep of
// the world, which is a solver substep then; 0: as the library chooses.
ClothCell hang(std::unique_ptr<World> world, const std::string& solver, double x, double y, int iterations) {
  ClothCell c;
  c.world = std::move(world);
  ClothDesc d = upright_sheet(kPoints, x, "top");
  d.solver = solver;
  d.max_strain = kInfinity;  // of the material
  if (iterations > 0) d.max_substeps = 1, d.solver_options.set("iterations", static_cast<double>(iterations));
  const double mass = static_cast<double>(d.area_density) * y;
  const double strain = (mass + 0.5 * static_cast<double>(d.area_density)) * kGravity / x;
  c.sheet = hang_sheet(*c.world, d, mass);
  c.energy = (mass + static_cast<double>(d.area_density)) * kGravity * (1 + 2 * strain);
  c.length = 1 + 2 * strain;
  c.expected = strain < 0.2 ? strain : NAN;  // else it is still falling when time is up
  c.error = [](ClothCell& e) { return std::fabs(hung_length(e.world->need<Cloth>(), e.sheet) - 1 - e.expected); };
  return c;
}

// x = stretch stiffness, y = mass of the bar by that of the sheet.
ClothCell hung(const std::string& solver, double x, double y) { return hang(make_world(60), solver, x, y, 0); }

// x = stretch stiffness, y = steps a second. It must not pass the ball, nor stretch where its material would not.
ClothCell draped(const std::string& solver, double x, double y) {
  ClothCell c;
  c.world = make_world(y);
  Cloth& cloth = c.world->need<Cloth>();
  BodyDesc ball;
  ball.type = BodyType::fixed;
  ball.shape = make_sphere(Real(0.3));
  ball.friction_static = ball.friction_dynamic = 1;
  c.world->need<Rigid>().add_body(ball);
  ClothDesc d = square_sheet(kPoints, x);
  d.solver = solver;
  d.pose.position = Vec3(0, Real(0.5), 0);
  d.friction = 1;
  c.sheet.cloth = cloth.add_cloth(d);
  c.length = 1 + 2 * kGravity * static_cast<double>(d.area_density) / x;
  c.energy = static_cast<double>(d.area_density) * kGravity * c.length;
  c.expected = x >= 100 ? 0 : NAN;
  c.error = [](ClothCell& e) {
    double deepest = 0;
    const Cloth& sheets = e.world->need<Cloth>();
    for (std::size_t i = 0; i < sheets.vertex_count(e.sheet.cloth); ++i)
      deepest = std::max(deepest, 0.3 - static_cast<double>(length(sheets.point(e.sheet.cloth, i))));
    return deepest > 0.01 ? deepest + 0.1 : std::max(0.0, static_cast<double>(sheets.max_strain(e.sheet.cloth)) - 0.05);
  };
  return c;
}

// x = substeps, y = iterations, for solvers that have them: a bar of ten times the mass on a stiff sheet.
ClothCell swept(const std::string& solver, double x, double y) {
  return hang(make_world(60, static_cast<int>(x)), solver, 1e4, 10, static_cast<int>(y));
}

// Shapes of the map of pinned sheets, by number, with +x as the normal at x = 0.1.
ShapePtr mast(int kind) {
  const Real r = Real(0.1);
  switch (kind) {
    case 1: return make_sphere(r);
    case 2: return make_box(2 * r, 2, 2 * r);
    case 3: return make_capsule(r, 2);
    case 4: return make_cylinder(r, 2);
    case 5: return make_cone(2 * r, 2);
    case 6: {
      const Vec3 corners[] = {Vec3(-r, -1, 0), Vec3(r, -1, -r), Vec3(r, -1, r),
                              Vec3(-r, 1, 0),  Vec3(r, 1, -r),  Vec3(r, 1, r)};
      return make_hull(corners);
    }
    case 7: return make_plane(Vec3(1, 0, 0), r);
    default: {
      const Vec3 corners[] = {Vec3(r, -1, -1), Vec3(r, -1, 1), Vec3(r, 1, 1), Vec3(r, 1, -1)};
      const std::uint32_t faces[] = {0, 2, 1, 0, 3, 2};
      return make_mesh(corners, faces);
    }
  }
}

// x = gap from the shape's surface to the pinned border, mm; y = shape. A vertex that is free must not lie inside, and
// no step may take more than five times the work of the mean.
ClothCell pinned(const std::string& solver, double x, double y) {
  ClothCell c;
  c.world = make_world(60);
  c.seconds = 1;
  BodyDesc b;
  b.type = BodyType::fixed;
  b.shape = c.shape = mast(static_cast<int>(y));
  c.world->need<Rigid>().add_body(b);
  ClothDesc d = upright_sheet(kPoints, 8000, "left");
  d.solver = solver;
  d.area_density = Real(0.4), d.thickness = Real(0.012);
  d.pose.position = Vec3(static_cast<Real>(0.6 + 0.001 * x), 0, 0);
  c.sheet.cloth = c.world->need<Cloth>().add_cloth(d);
  Params wind;
  wind.set("velocity", std::vector<double>{3, 0, -9});
  ForceEntry all;
  all.all = true;
  c.world->add_force("wind", wind, std::move(all), "", 0);
  c.energy = 0.5 * static_cast<double>(d.area_density) * 9.5 * 9.5;  // of the sheet at the speed of the wind
  c.expected = 0;
  c.error = [](ClothCell& e) {
    const Cloth& cloth = e.world->need<Cloth>();
    const ObjectId sheet = e.sheet.cloth;
    double deepest = e.most_work > 5 * e.mean_work ? 1 : 0;
    Vec3 normal;
    for (std::size_t i = 0; i < cloth.vertex_count(sheet); ++i)
      if (!cloth.pinned(sheet, i))
        deepest = std::max(deepest, -static_cast<double>(e.shape->distance(cloth.point(sheet, i), 1, normal)));
    return deepest > 0.002 ? deepest + 0.1 : 0;
  };
  return c;
}

bool takes_iterations(const std::string& solver) {
  Arena unused("stability");
  Params options;
  options.set("iterations", 2.0);
  try {
    find_variant(cloth_solvers(), solver, "cloth solver").make(unused, options);
    options.check_all_read(solver);
  } catch (const SceneError&) {
    return false;
  }
  return true;
}

struct ClothMapRow {
  StabilityProblemInfo info;
  ClothCell (*make)(const std::string& solver, double x, double y);
  bool iterates = false;  // only for solvers that take iterations
};

std::vector<ClothMapRow> rows() {
  const StabilityAxis stiffness = {"stiffness", "stretch stiffness", "N/m", true, decades(0, 6), {1, 1e3, 1e6}};
  return {{{"hanging_sheet",
            "a sheet of 10 x 10 cells hung by its border, a bar at the other, 60 steps/s",
            stiffness,
            {"ratio", "mass ratio", "", true, decades(0, 4), {1, 1e2, 1e4}}},
           &hung},
          {{"drape",
            "a sheet of 10 x 10 cells falls on a ball",
            stiffness,
            {"rate", "steps per second", "1/s", true, {15, 30, 60, 120, 240}, {15, 120}}},
           &draped},
          {{"pinned_gap",
            "a sail of 10 x 10 cells pinned beside, on and in a shape, in wind of 9.5 m/s, 60 steps/s",
            {"gap", "gap", "mm", false, {-20, -10, -5, -2, 0, 2, 5, 10, 20}, {-20, 0, 5}},
            {"shape",
             "1 sphere, 2 box, 3 capsule, 4 cylinder, 5 cone, 6 hull, 7 plane, 8 mesh",
             "",
             false,
             {1, 2, 3, 4, 5, 6, 7, 8},
             {2, 4, 6}}},
           &pinned},
          {{"sheet_substeps",
            "a sheet of 10 x 10 cells of 1e4 N/m with a bar of ten times its mass, 60 steps/s",
            {"substeps", "substeps", "", true, {1, 2, 4, 8, 16, 32, 64}, {1, 8, 64}},
            {"iterations", "iterations in each", "", true, {1, 2, 4, 8, 16, 32}, {1, 32}}},
           &swept,
           true}};
}

double row_updates(const World& w) {
  for (const Residual& r : w.residuals())
    if (r.name == "cloth.row_updates") return r.value;
  return 0;
}

StabilityCell run_cloth(const ClothMapRow& row, const std::string& method, double x, double y,
                        const StabilityThresholds& limits) {
  ClothCell c = row.make(method, x, y);
  World& w = *c.world;
  Arena unused("stability");
  const double steps = std::round(c.seconds / w.desc().dt);
  StabilityRun run{w, c.seconds, c.energy};
  // as for nets: the overflow of an explicit method, which was warned of, is divergence
  run.overflows = !find_variant(cloth_solvers(), method, "cloth solver").make(unused, Params())->sheds_strain();
  run.record = [&] {
    const double work = row_updates(w);
    c.most_work = std::max(c.most_work, work), c.mean_work += work / steps;
  };
  run.error = [&c] { return std::isnan(c.expected) ? NAN : c.error(c) / c.length; };
  return run_cell(run, x, y, limits);
}

}  // namespace

StabilityProblems cloth_stability() {
  StabilityProblems all;
  for (const ClothMapRow& row : rows()) {
    std::vector<StabilityMethod> methods = solver_methods(cloth_solvers());
    if (row.iterates) std::erase_if(methods, [](const StabilityMethod& m) { return !takes_iterations(m.name); });
    all.push_back(stability_table("cloth", row.info, std::move(methods),
                                  [row](const auto&... cell) { return run_cloth(row, cell...); }));
  }
  return all;
}

}  // namespace feder
