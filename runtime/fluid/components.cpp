// Connected components of a fluid, for the CFL number. The number bounds how far particles move relative to what acts
// on them in a substep (Courant, Friedrichs & Lewy 1928), so a velocity that a whole component shares does not count:
// the equations are the same in its frame (Galilei). Components are runs of occupied cells of the neighbour grid that
// are adjacent, corners included, so separate ones are farther apart than the support; runs are labelled as runs of
// pixels are (Rosenfeld & Pfaltz 1966). Components whose boxes come nearer than the support within the substep, along
// the difference of their velocities, are united. A component of one particle that meets only the boundary does not
// count: it has no pressure to resolve, and the non-penetration projection keeps it from passing. One of several
// particles that meets the boundary, the pool in its tank, counts in the frame of the world; so does one that hardly
// moves as a whole. Kept between calls: nothing. Weak spot: boxes. A drop within the box of a large component (between
// the walls of a splash), or on a slanted path beside one, counts as met before it is.
#include "fluid/components.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <span>

#include "fluid/block_sums.h"

namespace feder {
namespace {

constexpr JobGrain kRuns{64, 20'000};
constexpr std::size_t kFewComponents = 16;
constexpr int kMaxTraceSteps = 16;  // of sphere tracing beside a solid, before it counts as met

// Occupied cells side by side along x. Their particles are order[first .. last).
struct CellRun {
  int x0, x1;
  std::uint32_t first, last;
  std::uint32_t parent;  // of the union-find: a run with a smaller number, or itself
};

struct Component {
  Aabb box, velocities;                     // m, m/s
  Real low = kInfinity, high = -kInfinity;  // of g . x, m^2/s^2
  Real speed2 = 0;                          // largest in the frame of the world, m^2/s^2
  std::uint32_t count = 0, parent = 0;
  bool meets_shape = false, meets_fluid = false, alone = false;

  // Its frame, m/s: the middle of its velocities where that is faster than it moves within itself.
  Vec3 velocity() const { return moves() ? middle() : Vec3(Vec3::Zero()); }
  // Largest squared speed in this frame, m^2/s^2: no corner of the box of velocities is farther from its middle than
  // half the diagonal.
  Real frame_speed2() const { return moves() ? spread2() : speed2; }
  Real frame_speed() const { return std::sqrt(frame_speed2()); }
  bool moves() const { return !meets_shape && dot(middle(), middle()) > spread2(); }
  Vec3 middle() const { return (velocities.lo + velocities.hi) / 2; }
  Real spread2() const {
    const Vec3 half = (velocities.hi - velocities.lo) / 2;
    return dot(half, half);
  }

  void include(const Vec3& x, const Vec3& v, Real potential) {
    box.include(x), velocities.include(v);
    low = std::min(low, potential), high = std::max(high, potential);
    speed2 = std::max(speed2, dot(v, v));
    ++count;
  }
  void include(const Component& c) {
    box.include(c.box), velocities.include(c.velocities);
    low = std::min(low, c.low), high = std::max(high, c.high);
    speed2 = std::max(speed2, c.speed2);
    count += c.count;
    meets_shape = meets_shape || c.meets_shape;
    meets_fluid = true;
  }
};

template <class T>
std::uint32_t root_of(T* nodes, std::uint32_t i) {
  while (nodes[i].parent != i) {
    nodes[i].parent = nodes[nodes[i].parent].parent;
    i = nodes[i].parent;
  }
  return i;
}

template <class T>
void unite(T* nodes, std::uint32_t a, std::uint32_t b) {
  a = root_of(nodes, a), b = root_of(nodes, b);
  nodes[std::max(a, b)].parent = std::min(a, b);
}

// The runs of all rows, row by row; row_first gets the first of each, and one more.
std::uint32_t find_runs(const CellGrid& g, CellRun* runs, std::uint32_t* row_first) {
  std::uint32_t n = 0, row = 0;
  const int last_x = g.cells(0) - 1;
  for (int z = 0; z < g.cells(2); ++z)
    for (int y = 0; y < g.cells(1); ++y) {
      row_first[row++] = n;
      std::uint32_t at = g.first(0, y, z);
      const std::uint32_t end = g.last(last_x, y, z);
      bool open = false;
      for (int x = 0; x <= last_x && (at < end || open); ++x) {
        const std::uint32_t next = g.last(x, y, z);
        const bool occupied = next > at;
        if (occupied && !open) runs[n] = {x, x, at, next, n}, ++n;
        if (occupied) runs[n - 1].x1 = x, runs[n - 1].last = next;
        open = occupied, at = next;
      }
    }
  row_first[row] = n;
  return n;
}

// Unites the adjacent runs of two neighbouring rows.
void join_rows(CellRun* runs, const std::uint32_t* row_first, std::uint32_t a, std::uint32_t b) {
  std::uint32_t i = row_first[a], j = row_first[b];
  while (i < row_first[a + 1] && j < row_first[b + 1]) {
    if (runs[i].x0 <= runs[j].x1 + 1 && runs[j].x0 <= runs[i].x1 + 1) unite(runs, i, j);
    runs[i].x1 < runs[j].x1 ? ++i : ++j;
  }
}

void join_runs(const CellGrid& g, CellRun* runs, const std::uint32_t* row_first) {
  const int ny = g.cells(1);
  for (int z = 0; z < g.cells(2); ++z)
    for (int y = 0; y < ny; ++y) {
      const auto row = static_cast<std::uint32_t>(z * ny + y), below = row - static_cast<std::uint32_t>(ny);
      if (row_first[row] == row_first[row + 1]) continue;
      if (y > 0) join_rows(runs, row_first, row - 1, row);
      if (z == 0) continue;
      if (y > 0) join_rows(runs, row_first, below - 1, row);
      join_rows(runs, row_first, below, row);
      if (y + 1 < ny) join_rows(runs, row_first, below + 1, row);
    }
}

// The particles of the runs, which block by block have components of their own where these are few: their extremes and
// counts are the same in any order.
void include_particles(const FluidPool& p, const Vec3& gravity, std::span<const CellRun> runs,
                       const std::uint32_t* component_of, std::span<Component> list, const StepContext& c) {
  const auto include = [&](std::uint32_t first, std::uint32_t last, Component* out) {
    for (std::uint32_t k = first; k < last; ++k)
      for (std::uint32_t at = runs[k].first; at < runs[k].last; ++at) {
        const std::uint32_t i = p.order[at];
        const Vec3 x = p.x[i].vec();
        out[component_of[k]].include(x, p.v[i].vec(), dot(gravity, x));
      }
  };
  const auto n = static_cast<std::uint32_t>(runs.size());
  const std::size_t blocks = block_count(n, kRuns);
  if (list.size() > kFewComponents || blocks == 1) return include(0, n, list.data());
  const Scratch::Frame frame(*c.scratch);
  Component* parts = c.scratch->take<Component>(blocks * list.size());
  c.jobs->for_blocks(n, kRuns, [&](std::uint32_t first, std::uint32_t last, int) {
    Component* own = parts + first / kRuns.items * list.size();
    for (std::size_t k = 0; k < list.size(); ++k) new (&own[k]) Component;
    include(first, last, own);
  });
  for (std::size_t b = 0; b < blocks; ++b)
    for (std::size_t k = 0; k < list.size(); ++k) {
      list[k].include(parts[b * list.size() + k]);
      list[k].meets_fluid = false;  // it is one component, not two that met
    }
}

// Whether a box that moves by `travel` comes nearer than `margin` to a solid. A convex shape lies wholly behind the
// plane through its nearest point; for others the bounding ball of the box is traced along its path in steps of the
// distance (sphere tracing, Hart 1996), so a solid beside the path is not met.
bool meets_shape(const Aabb& box, const Vec3& travel, Real margin, const BoundaryShape& w) {
  const Vec3 middle = (box.lo + box.hi) / 2, half = (box.hi - box.lo) / 2;
  const Real ball_radius = length(half) + margin, whole = length(travel);
  Aabb swept{middle, middle};
  swept.include(Vec3(middle + travel));
  swept.grow(ball_radius);
  if (!overlaps(swept, w.box)) return false;
  Real traced = 0;  // m
  for (int step = 0;; ++step) {
    const Vec3 at = whole > 0 ? Vec3(middle + (traced / whole) * travel) : middle;
    Vec3 normal = Vec3::Zero();
    const Real d = w.shape->distance(to_local(w.pose, at), ball_radius + whole, normal);
    if (d >= ball_radius + whole) return false;
    if (step == 0 && w.shape->convex()) {
      const Vec3 n = rotate(w.pose.rotation, normal);
      if (d + std::min(Real(0), dot(n, travel)) > dot(n.cwiseAbs(), half) + margin) return false;
    }
    if (!(d > ball_radius) || step == kMaxTraceSteps) return true;
    traced += d - ball_radius;
    if (traced >= whole) return false;
  }
}

bool meets_boundary(const Component& c, const FluidPool& p, const Boundary& boundary, Real h, Real fall) {
  const Vec3 velocity = c.velocity();
  const Real margin = p.support + h * c.frame_speed() + fall;
  for (const BoundaryShape& w : boundary.shapes) {
    if (!p.meets(w)) continue;
    const BoundaryBody& b = boundary.bodies[w.body];
    const Real arc =
        b.angular_velocity.isZero(0) ? Real(0) : h * length(b.angular_velocity) * w.shape->extent(Vec3::Zero());
    if (meets_shape(c.box, h * (velocity - b.velocity), margin + arc, w)) return true;
  }
  return false;
}

// Whether two components come nearer than the support within h; the motion within each counts in all directions.
bool meet(const Component& a, const Component& b, Real support, Real h, Real fall) {
  Aabb swept = a.box;
  const Vec3 travel = h * (a.velocity() - b.velocity());
  swept.include(Aabb{a.box.lo + travel, a.box.hi + travel});
  swept.grow(support + h * (a.frame_speed() + b.frame_speed()) + fall);
  return overlaps(swept, b.box);
}

// Unites the components that meet: sort and sweep along x over their swept boxes.
void unite_meeting(Component* list, std::uint32_t n, Real support, const StepContext& c, Real fall) {
  struct Entry {
    Aabb swept;
    std::uint32_t component;
  };
  Entry* entries = c.scratch->take<Entry>(n);
  for (std::uint32_t k = 0; k < n; ++k) {
    const Vec3 travel = c.h * list[k].velocity();
    Aabb swept = list[k].box;
    swept.include(Aabb{swept.lo + travel, swept.hi + travel});
    swept.grow(support / 2 + c.h * list[k].frame_speed() + fall);
    entries[k] = {swept, k};
  }
  std::sort(entries, entries + n, [](const Entry& a, const Entry& b) {
    return a.swept.lo[0] != b.swept.lo[0] ? a.swept.lo[0] < b.swept.lo[0] : a.component < b.component;
  });
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t j = i + 1; j < n && entries[j].swept.lo[0] <= entries[i].swept.hi[0]; ++j) {
      const std::uint32_t a = entries[i].component, b = entries[j].component;
      if (overlaps(entries[i].swept, entries[j].swept) && meet(list[a], list[b], support, c.h, fall)) unite(list, a, b);
    }
  // roots have the smallest index of their sets; velocities are summed only after all are united
  for (std::uint32_t k = 0; k < n; ++k) {
    const std::uint32_t root = root_of(list, k);
    FEDER_ASSERT(root <= k);
    if (root != k) list[root].include(list[k]);
  }
}

}  // namespace

FlowScales flow_scales(FluidPool& p, const Boundary& boundary, const StepContext& c) {
  FEDER_ASSERT(p.count > 0 && c.h > 0);
  // runs of occupied cells
  p.grid.sort({&p.x[0].x, 4 * std::size_t(p.count)}, p.support, *c.jobs, p.order);
  const std::size_t rows = static_cast<std::size_t>(p.grid.cells(1)) * static_cast<std::size_t>(p.grid.cells(2));
  std::uint32_t* row_first = c.scratch->take<std::uint32_t>(rows + 1);
  CellRun* runs = c.scratch->take<CellRun>(p.count);
  const std::uint32_t n = find_runs(p.grid, runs, row_first);
  FEDER_ASSERT(n >= 1 && n <= p.count);
  join_runs(p.grid, runs, row_first);

  // components by run: a root has a smaller index than its runs, so its component is known
  std::uint32_t components = 0;
  std::uint32_t* component_of = c.scratch->take<std::uint32_t>(n);
  for (std::uint32_t k = 0; k < n; ++k) {
    const std::uint32_t root = root_of(runs, k);
    component_of[k] = root == k ? components++ : component_of[root];
  }
  Component* list = c.scratch->take<Component>(components);
  for (std::uint32_t k = 0; k < components; ++k) new (&list[k]) Component, list[k].parent = k;
  const Vec3 gravity = p.weight(c.gravity);
  include_particles(p, gravity, {runs, n}, component_of, {list, components}, c);

  // who meets whom in the substep
  const Real fall = length(gravity) * c.h * c.h;
  for (std::uint32_t k = 0; k < components; ++k)
    list[k].meets_shape = list[k].count > 1 && meets_boundary(list[k], p, boundary, c.h, fall);
  if (components > 1) unite_meeting(list, components, p.support, c, fall);

  // isolated particles do not count
  const auto alone = [](const Component& one) { return one.count == 1 && !one.meets_fluid; };
  for (std::uint32_t k = 0; k < components; ++k) list[k].alone = alone(list[root_of(list, k)]);
  c.jobs->for_blocks(n, kRuns, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t k = first; k < last; ++k)
      for (std::uint32_t at = runs[k].first; at < runs[k].last; ++at)
        p.isolated[p.order[at]] = list[component_of[k]].alone;
  });

  FlowScales scales;
  for (std::uint32_t k = 0; k < components; ++k) {
    const Component& one = list[k];
    if (one.parent != k || alone(one)) continue;
    scales.speed2 = std::max(scales.speed2, one.frame_speed2());
    scales.head = std::max(scales.head, one.high - one.low);
  }
  scales.head += p.squeeze;
  return scales;
}

ColumnScales column_scales(const FluidPool& p, const StepContext& c) {
  const Vec3 gravity = p.weight(c.gravity);
  constexpr Real kCompany = Real(0.2);  // least density over density at rest by neighbours
  struct Sums {
    Real speed2 = 0, low = kInfinity;
    double depth = 0, roots = 0;
    std::uint32_t count = 0;
    Aabb box;
    void add(const Sums& s) {
      speed2 = std::max(speed2, s.speed2), low = std::min(low, s.low);
      depth += s.depth, roots += s.roots, count += s.count;
      box.include(s.box);
    }
  };
  const Sums all = sum_blocks<Sums>(p.count, kParticleGrain, *c.jobs, *c.scratch, [&](std::uint32_t i, Sums& sums) {
    const Vec3 v = p.v[i].vec();
    sums.speed2 = std::max(sums.speed2, dot(v, v));
    if (p.ratio[i] < p.own_value + kCompany) return;
    const Real s = -dot(gravity, p.x[i].vec());
    sums.low = std::min(sums.low, s), sums.depth += static_cast<double>(s), ++sums.count;
    sums.roots += static_cast<double>(std::sqrt(length(v)));
    sums.box.include(p.x[i].vec());
  });
  const Real g = length(gravity);
  ColumnScales column;
  column.speed2 = all.speed2, column.count = all.count, column.box = all.box;
  if (all.count > 0) {
    const double root = all.roots / all.count;
    column.pace = static_cast<Real>(root * root);
  }
  if (g > 0 && all.count > 0)
    column.height = 2 * (static_cast<Real>(all.depth / all.count) - all.low) / g + p.desc.spacing;
  column.head = g * column.height + (all.count > 0 ? p.squeeze : Real(0));
  return column;
}

Real speed_near(FluidPool& p, const ColumnScales& column, const Boundary& boundary, Real travel, const StepContext& c) {
  const Real own = std::sqrt(column.speed2);
  Real speed = c.h * own > travel ? std::sqrt(flow_scales(p, boundary, c).speed2) : own;
  if (column.count == 0) return speed;
  Aabb box = column.box;
  box.grow(p.support);
  for (const BoundaryShape& w : boundary.shapes) {
    const Real fast = length(boundary.bodies[w.body].velocity);
    Aabb swept = w.box;
    swept.grow(c.h * fast);
    if (overlaps(swept, box)) speed = std::max(speed, fast);
  }
  return speed;
}

}  // namespace feder
