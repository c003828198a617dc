// Pressure that keeps densities from growing, as a quadratic programme with bounds: with G the change of the densities
// (over density at rest) by the motion of particles and bodies and M their masses, multipliers l >= 0 are sought with
//   u = u* + M^-1 G^T l,  G u <= allowed,  l = 0 where G u < allowed,
// which are the conditions of min l A l / 2 - b l, A = G M^-1 G^T. u: velocities (m/s; l in kg m^2/s, and l / (h V) is
// the pressure over the squared density ratio) or displacements (m). Pair terms are those of a density, so A is
// symmetric, momentum is kept, and what pressure takes from the flow is the least that it can.
// Solved by conjugate gradients, scaled by the diagonal, among the particles under pressure: a step goes up to the
// bounds particle by particle (Polyak 1969; More & Toraldo 1991), then along what is left of it to the least of the
// energy, and the next direction is conjugate to that. The energy falls with every step. A column of n layers takes
// some n iterations, not n^2. Sums run over blocks in order: same bits for any number of threads.
#pragma once
#include "base/jobs.h"
#include "fluid/pool.h"

namespace feder {

class PressureSystem {
 public:
  explicit PressureSystem(Arena& arena) : sums_(&arena), moved_(&arena), before_(&arena), started_(&arena) {}

  struct Result {
    int iterations = 0;
    double error = 0;  // mean of what densities grow more than allowed, or less where there is pressure; unit of G u
  };
  // The pools of the coming solves: neighbours and boundary contacts must be fresh.
  void begin(Boundary* boundary) { pools_.clear(), boundary_ = boundary; }
  void add(FluidPool& p) { pools_.push_back(&p); }
  bool empty() const { return pools_.empty(); }
  // Density ratios, the diagonal, and the share of each kernel that lies in the air, where the particles are.
  void prepare(JobPool& jobs);
  // Of the ratios of a pool: mean of what is above 1, and whether one is above 1 + `bound`.
  struct Excess {
    double mean = 0;
    bool beyond = false;
  };
  Excess excess(FluidPool& p, Real bound, JobPool& jobs);
  // The multipliers in `lambda` push particles and bodies; then other forces may, and then solve_velocities.
  void start_velocities(JobPool& jobs);
  // Velocities `v`, from those multipliers on; allowed growth in `allowed`, 1/s, and `compliance` for each multiplier.
  // Pushes bodies.
  Result solve_velocities(double tolerance, int most, JobPool& jobs);
  // Displacements, in `extra`, of particles alone, from none; `allowed` is negative where the fluid is too dense.
  // Softened: each multiplier leaves some of the error.
  Result solve_displacements(double tolerance, int most, JobPool& jobs);

 private:
  struct Sums {
    double descent = 0, curvature = 0, conjugate = 0, error = 0, room = 1e300;
    void add(const Sums& s);
  };
  template <class F>
  Sums sum_of(FluidPool& p, JobPool& jobs, F&& f);  // f(pool, i, sums)
  template <class F>
  Sums sum(JobPool& jobs, F&& f);  // of all pools
  template <class F>
  void each(JobPool& jobs, F&& f);  // f(pool, i)
  Array<Row4>& state(FluidPool& p) const { return bodies_ ? p.v : p.extra; }
  Array<Real>& multipliers(FluidPool& p) const { return bodies_ ? p.lambda : p.shifts; }
  Real wall_growth(const FluidPool& p, std::uint32_t i, bool of_moved) const;
  void press(JobPool& jobs);                // direction in `next_weight` -> M^-1 G^T of it, in `move` and moved_
  void grow(JobPool& jobs, bool of_moved);  // G of that, softened, or of the state, to `sum`
  void step(Real size, JobPool& jobs);
  void clear_weights(JobPool& jobs);
  static void weigh_by_lightness(FluidPool& p, JobPool& jobs);
  void find_residuals(JobPool& jobs);
  Result solve(double tolerance, int most, JobPool& jobs);

  std::vector<FluidPool*> pools_;
  Boundary* boundary_ = nullptr;
  bool bodies_ = false;  // velocities, not displacements
  bool boundary_moves_ = false;
  Array<Sums> sums_;
  struct Motion {
    Vec3 velocity = Vec3::Zero(), angular_velocity = Vec3::Zero();
  };
  Array<Motion> moved_;  // by body: of the direction
  // By body: velocities without pressure; after start_velocities().
  Array<Motion> before_, started_;
};

}  // namespace feder
