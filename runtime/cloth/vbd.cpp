// Vertex block descent (Chen, Liu, Yang and Yuksel, "Vertex Block Descent", SIGGRAPH 2024): implicit Euler by block
// coordinate descent on the incremental potential that implicit.cpp writes out. In a sweep each vertex moves to the
// minimum of the quadratic model of its own energy, its neighbours held (eq. 8, 9); vertices of a colour share no link
// and no hinge, so a colour runs eight wide and on any thread with the same bits. First guess: along the external
// acceleration as far as elastic forces at the start leave it (section 3.7 has the acceleration of the last step there,
// which would be state to keep; the same at rest and in free fall). So a cloth at rest is an exact fixed point of any
// number of sweeps. Instead of Chebyshev weights (section 3.8) moves are over-relaxed by `relaxation`: below 2 a move
// never raises the vertex's model. Soft hinges act as forces of the start, softer ones at the state of sweeps 1, 5, 17
// .., which converges to those at the end; stiff ones are linearised there, and a moving vertex turns its hinges at
// once. Damping as in damping.cpp, less the method's own of tau = h. Sweeps do not keep momentum: a free cloth is
// shifted back onto its goal, and step.cpp takes out what they add of angular momentum. After the sweeps strain limit
// and ties, as in mass_spring. Kept between steps: batches of the mesh. Weak spot: errors over many cells converge
// slowly, some hundred sweeps for a fine stiff sheet, so fast motion of one is too soft and too damped; rest is exact.
#include <algorithm>
#include <cmath>

#include "base/jobs.h"
#include "base/wide.h"
#include "cloth/batches.h"
#include "cloth/descent.h"
#include "cloth/dihedral.h"

namespace feder {
namespace {

// h^2 times the largest rate of links and of hinges that a sweep copes with
constexpr double kStretchPerSweep = 8, kBendingPerSweep = 1;
constexpr double kSoftBending = 0.1;  // largest h^2 k sum w |gradient|^2 of hinges that act as forces
constexpr Real kLimitFrom = Real(0.98), kLimitTimes = 100, kNoLimit = Real(1e18);
constexpr double kSettling = 0.3;              // largest h^2 w^2 of bending at which taking them anew converges
constexpr JobGrain kDescentGrain{16, 4'000};   // batches per job
constexpr JobGrain kVertexGrain{1024, 4'000};  // vertices per job
constexpr std::size_t kMaxSweepStages = 64;

class Vbd final : public ClothSolver {
 public:
  Vbd(Arena& a, const Params& p)
      : iterations_(p.integer({"iterations", "", {1, 10'000}}, 5)),
        relaxation_(p.real({"relaxation", "", {0, 2, true}}, 1)), batches_(a), link_lane_(&a), descent_(&a), links_(&a),
        entries_(&a), bends_(&a), colors_(&a), force_(&a), kicked_(&a), angle_(&a) {
    const bool wide = wide_kernels(p);
    batches_.pick(wide);
#if defined(__x86_64__) || defined(__i386__)
    if (wide && runs_avx2()) kernels_ = &kDescentAvx2;
#endif
  }

  void prepare(const ClothView& v, StepContext& c) override {
    batches_.build(v);
    batches_.current_position(v, *c.jobs);
    build(v);
    if (v.flows) take_rests(v);
    afloat_ = true;
    for (std::uint32_t i = 0; i < v.points; ++i) afloat_ = afloat_ && v.delta_position[i].w != 0;
    for (DescentBend& b : bends_)
      for (int k = 0; k < 3; ++k)
        for (int n = 0; n < kLanes; ++n) put(b.base[k], n, v.position[b.v[k + 1][n]] - v.position[b.v[0][n]]);
    for (DescentBatch& b : descent_)
      for (unsigned k = b.first_link; k < b.last_link; ++k)
        for (int n = 0; n < kLanes; ++n) put(links_[k].base, n, v.position[links_[k].other[n]] - v.position[b.self[n]]);
  }

  void advance(const ClothView& v, double, Real h, StepContext& c) override {
    FEDER_ASSERT(version_ == v.version && h > 0);
    const bool bends = !bends_.empty();
    stiff_ = stiffest_ * double(h) * double(h) > kSoftBending;
    settles_ = crowded_ * double(h) * double(h) <= kSettling;
    DescentPass p = pass(v, h);
    // kick
    each_vertex(v, c, [&](std::uint32_t i) {
      v.before[i] = {v.delta_position[i].x, v.delta_position[i].y, v.delta_position[i].z, 0};
      if (v.delta_position[i].w != 0) v.velocity[i].add(h * v.acceleration[i]);
      kicked_[i] = v.velocity[i];
    });
    if (bends && !stiff_) batches_.bend(v, h, c);
    aim(v, h, c);
    // guess
    if (p.hinged) run({0, static_cast<std::uint32_t>(bends_.size())}, p, kernels_->bend, c);
    sweep(p, kernels_->begin, c);
    each_vertex(v, c, [&](std::uint32_t i) {
      if (v.delta_position[i].w == 0) return;
      const Vec3 goal = v.before[i].vec() + h * v.velocity[i].vec();
      v.delta_position[i].set(goal - (h * h) * held_back(v.acceleration[i], v.delta_position[i].w * force_[i].vec()));
    });
    // sweeps
    for (int k = 0; k < iterations_; ++k) {
      if (bends && anew(k)) {
        if (stiff_) {
          run({0, static_cast<std::uint32_t>(bends_.size())}, p, kernels_->bend, c);
        } else if (k > 0) {
          each_vertex(v, c, [&](std::uint32_t i) { v.velocity[i] = kicked_[i]; });
          batches_.bend(v, h, c);
          aim(v, h, c);
        }
      }
      sweep(p, kernels_->descend, c);
    }
    if (afloat_) centre(v, h);
    batches_.tie(v, h, c);
    // hinges at a swept state push with a torque about where it began: it counts as what the sweeps add
    if (bends && !stiff_ && settles_) each_vertex(v, c, [&](std::uint32_t i) { v.velocity[i] = kicked_[i]; });
  }

  void damp(const ClothView& v, Real h, StepContext& c) override {
    ClothView less = v;
    less.damping = v.damping - step_;
    if (less.damping > 0) batches_.damp_links(less, h, c), batches_.damp_hinges(less, h, c);
  }
  double longest_damping(Real h) const override { return batches_.longest_damping(h); }
  void validate(const ClothView& v) const override {
    batches_.validate(v);
    if (version_ != v.version) return;
    std::uint32_t next = 0;
    for (const Range& r : colors_) {
      FEDER_ASSERT(r.first == next && r.last > r.first);
      next = r.last;
    }
    FEDER_ASSERT(next == descent_.size() && bends_.size() == (v.mesh->hinges.size() + kLanes - 1) / kLanes);
    for (const DescentBatch& b : descent_) {
      FEDER_ASSERT(b.last_link <= links_.size() && b.last_hinge <= entries_.size());
      for (const unsigned i : b.self) FEDER_ASSERT(i < v.points || i + 1 == v.total);
    }
  }
  // So that its sweeps reach over the waves that a solver substep resolves.
  double wanted_substeps(const ClothView& v, Real h) const override {
    const double rate = std::fmax(stiffest_link(v) / kStretchPerSweep, stiffest_hinge(v) / kBendingPerSweep);
    return std::sqrt(rate / iterations_) * double(h);
  }
  bool sheds_strain() const override { return false; }
  bool converges() const override { return true; }

 private:
  struct Range {
    std::uint32_t first, last;  // batches
  };

  DescentPass pass(const ClothView& v, Real h) {
    DescentPass p{};
    p.batches = descent_.data(), p.links = links_.data(), p.hinges = entries_.data();
    p.delta_position = &v.delta_position->x, p.before = &v.before->x, p.force = &force_[0].x;
    p.angle = angle_.data();
    p.bends = bends_.data();
    p.inv_h2 = 1 / (h * h), p.relaxation = relaxation_;
    p.stretched = v.max_strain < kInfinity ? 1 + kLimitFrom * v.max_strain : kNoLimit;
    p.limit = kLimitTimes, p.shed = kShedSpeed * h;
    p.hinged = stiff_ && !bends_.empty();
    step_ = h;
    return p;
  }

  template <class F>
  void each_vertex(const ClothView& v, StepContext& c, F&& f) {
    c.jobs->for_blocks(v.total, kVertexGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t i = first; i < last; ++i) f(i);
    });
  }

  // Are hinges taken anew before this sweep? 0, 4, 16, 64 .., and 1 for stiff ones.
  bool anew(int sweep) const {
    if (!stiff_ && !settles_) return sweep == 0;
    return (sweep & (sweep - 1)) == 0 && (sweep & 0x2aaaaaaa) == 0 && (stiff_ || sweep != 1);
  }
  static void put(Lane8x3& to, int n, const Vec3& d) { to.x.v[n] = d[0], to.y.v[n] = d[1], to.z.v[n] = d[2]; }

  static void run(Range range, const DescentPass& p, void (*kernel)(const DescentPass&), StepContext& c) {
    c.jobs->for_blocks(range.last - range.first, kDescentGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      DescentPass part = p;
      part.first = range.first + first, part.last = range.first + last;
      kernel(part);
    });
  }

  // Colour after colour: empty lanes of each name the spare vertex.
  void sweep(const DescentPass& p, void (*kernel)(const DescentPass&), StepContext& c) {
    for_colors(colors_, kDescentGrain, stages_, *c.jobs, [&](std::uint32_t first, std::uint32_t last, int) {
      DescentPass part = p;
      part.first = first, part.last = last;
      kernel(part);
    });
  }

  // Part of the acceleration that the guess leaves out: what elastic forces take of it, between none and all.
  static Vec3 held_back(const Vec3& external, const Vec3& elastic) {
    const Real square = dot(external, external);
    if (!(square > 0)) return Vec3(0, 0, 0);
    return clamp(-dot(elastic, external) / square, 0, 1) * external;
  }

  // Masses, and goals of the vertices from their velocities.
  void aim(const ClothView& v, Real h, StepContext& c) {
    c.jobs->for_blocks(
        static_cast<std::uint32_t>(descent_.size()), {128, 4'000}, [&](std::uint32_t first, std::uint32_t last, int) {
          for (std::uint32_t n = first; n < last; ++n)
            for (int i = 0; i < kLanes; ++i) {
              DescentBatch& b = descent_[n];
              const Row4 &x = v.before[b.self[i]], &u = v.velocity[b.self[i]];
              b.mass.v[i] = b.self[i] < v.points ? v.mass[b.self[i]] : Real(0);
              b.goal.x.v[i] = x.x + h * u.x, b.goal.y.v[i] = x.y + h * u.y, b.goal.z.v[i] = x.z + h * u.z;
            }
        });
  }

  // Sweeps add momentum where they have not converged: the centre of mass back to its goal.
  void centre(const ClothView& v, Real h) {
    Double3 off{0, 0, 0};
    double mass = 0;
    for (std::uint32_t i = 0; i < v.points; ++i) {
      const double m = double(v.mass[i]);
      off = off + m * wide(v.delta_position[i].vec() - v.before[i].vec() - h * v.velocity[i].vec());
      mass += m;
    }
    const Vec3 back = narrow((-1 / mass) * off);
    for (std::uint32_t i = 0; i < v.points; ++i) v.delta_position[i].add(back);
  }

  void build(const ClothView& v);

  // Rest lengths and angles that have flowed.
  void take_rests(const ClothView& v) {
    if (rests_ == v.rests) return;
    rests_ = v.rests;
    FEDER_ASSERT(link_lane_.size() == links_.size() * kLanes);
    for (std::size_t n = 0; n < link_lane_.size(); ++n)
      if (link_lane_[n] != kNone) links_[n / kLanes].rest.v[n % kLanes] = v.mesh->links[link_lane_[n]].rest;
    for (std::size_t k = 0; k < v.mesh->hinges.size(); ++k)
      sin_cos(v.mesh->hinges[k].angle, bends_[k / kLanes].sine.v[k % kLanes], bends_[k / kLanes].cosine.v[k % kLanes]);
  }

  int iterations_;
  Real relaxation_;
  const DescentKernels* kernels_ = &kDescentPlain;
  ClothBatches batches_;  // soft hinges, strain limit, ties, damping
  std::uint64_t version_ = ~std::uint64_t(0), rests_ = 0;
  Array<std::uint32_t> link_lane_;  // of cloth that flows: links of the mesh in the order of links_
  Array<DescentBatch> descent_;     // by colour
  Array<DescentLink> links_;        // by batch
  Array<DescentHinge> entries_;     // by batch
  Array<DescentBend> bends_;        // hinges in the order of the mesh
  Array<Range> colors_;
  Array<Row4> force_, kicked_;  // by vertex: N; m/s
  Array<Real> angle_;           // by hinge, then those of lanes without one
  JobPool::Stage stages_[kMaxSweepStages];
  double crowded_ = 0;                                     // bound of w^2 of bending, see damping.cpp, 1/s^2
  double stiffest_ = 0;                                    // largest k sum w |gradient|^2, 1/s^2
  bool stiff_ = false, settles_ = false, afloat_ = false;  // hinges are in the sweeps; soft ones converge; free
  Real step_ = 0;                                          // s, of the last solver substep
};

void Vbd::build(const ClothView& v) {
  if (version_ == v.version) return;
  version_ = v.version;
  const ClothMesh& mesh = *v.mesh;
  const auto link_count = static_cast<std::uint32_t>(mesh.links.size());
  const auto hinge_count = static_cast<std::uint32_t>(mesh.hinges.size());
  const Incidence link_at(v.points, [&](auto&& f) {
    for (std::uint32_t k = 0; k < link_count; ++k) f(mesh.links[k].a, k), f(mesh.links[k].b, k);
  });
  const Incidence hinge_at(v.points, [&](auto&& f) {
    for (std::uint32_t k = 0; k < hinge_count; ++k)
      for (const std::uint32_t i : mesh.hinges[k].v)
        if (i < v.points) f(i, k);
  });
  const std::uint32_t rounded = (hinge_count + kLanes - 1) / kLanes * kLanes;
  // greedy colours: the lowest that no vertex of its elements has
  std::vector<std::uint32_t> color(v.points, kNone), taken;
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < v.points; ++i) {
    taken.clear();
    const auto take = [&](std::uint32_t j) {
      if (j < v.points && color[j] != kNone) taken.push_back(color[j]);
    };
    for (const std::uint32_t k : link_at.of(i)) take(mesh.links[k].a), take(mesh.links[k].b);
    for (const std::uint32_t k : hinge_at.of(i))
      for (const std::uint32_t j : mesh.hinges[k].v) take(j);
    std::sort(taken.begin(), taken.end());
    std::uint32_t lowest = 0;
    for (const std::uint32_t t : taken) lowest = t == lowest ? lowest + 1 : lowest;
    color[i] = lowest;
    count = std::max(count, lowest + 1);
  }
  // batches, colour after colour
  std::vector<std::uint32_t> slots(std::size_t(4) * hinge_count, kNone);  // of gradients
  rests_ = v.rests;
  link_lane_.clear(), descent_.clear(), links_.clear(), entries_.clear(), colors_.clear();
  std::vector<std::uint32_t> members;
  for (std::uint32_t n = 0; n < count; ++n) {
    members.clear();
    for (std::uint32_t i = 0; i < v.points; ++i)
      if (color[i] == n) members.push_back(i);
    const auto first = static_cast<std::uint32_t>(descent_.size());
    for (std::size_t at = 0; at < members.size(); at += kLanes) {
      const auto number = static_cast<std::uint32_t>(descent_.size());
      DescentBatch b{};
      std::size_t most_links = 0, most_hinges = 0;
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const std::uint32_t i = at + lane < members.size() ? members[at + lane] : v.total - 1;
        b.self[lane] = i;
        if (i >= v.points) continue;
        most_links = std::max(most_links, link_at.of(i).size());
        most_hinges = std::max(most_hinges, hinge_at.of(i).size());
      }
      b.first_link = static_cast<unsigned>(links_.size()), b.first_hinge = static_cast<unsigned>(entries_.size());
      for (std::size_t k = 0; k < most_links; ++k) {
        DescentLink l{};
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
          const std::uint32_t i = b.self[lane];
          l.other[lane] = i;
          if (i >= v.points || k >= link_at.of(i).size()) continue;
          const ClothLink& from = mesh.links[link_at.of(i)[k]];
          l.other[lane] = from.a == i ? from.b : from.a;
          l.rest.v[lane] = from.rest, l.stiffness.v[lane] = from.stiffness;
          if (!v.flows) continue;
          link_lane_.resize((links_.size() + 1) * kLanes, kNone);
          link_lane_[links_.size() * kLanes + lane] = link_at.of(i)[k];
        }
        links_.push_back(l);
      }
      for (std::size_t k = 0; k < most_hinges; ++k) {
        DescentHinge e{};
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
          const std::uint32_t i = b.self[lane];
          e.hinge[lane] = rounded + number;
          if (i >= v.points || k >= hinge_at.of(i).size()) continue;
          const std::uint32_t hinge = hinge_at.of(i)[k];
          e.hinge[lane] = hinge;
          const auto slot = static_cast<std::uint32_t>(entries_.size() * kLanes + lane);
          for (std::size_t j = 0; j < 4; ++j)
            if (mesh.hinges[hinge].v[j] == i) slots[4 * hinge + j] = slot;
        }
        entries_.push_back(e);
      }
      b.last_link = static_cast<unsigned>(links_.size()), b.last_hinge = static_cast<unsigned>(entries_.size());
      descent_.push_back(b);
    }
    colors_.push_back({first, static_cast<std::uint32_t>(descent_.size())});
  }
  force_.assign(v.total, Row4{}), kicked_.assign(v.total, Row4{});
  angle_.assign(rounded + descent_.size(), 0);

  // hinges; gradients that nothing needs go to an entry behind the last
  const auto none = static_cast<std::uint32_t>(entries_.size() * kLanes);
  entries_.push_back({});
  bends_.clear();
  stiffest_ = stiffest_hinge(v);
  std::vector<double> sum(v.total, 0);
  for (const ClothHinge& k : mesh.hinges)
    for (const std::uint32_t i : k.v) sum[i] += hinge_response(v, k.v) * double(k.stiffness);
  crowded_ = *std::max_element(sum.begin(), sum.end());
  for (std::uint32_t k = 0; k < rounded; ++k) {
    const std::uint32_t lane = k % kLanes;
    if (lane == 0) bends_.push_back({});
    DescentBend& b = bends_.back();
    for (std::uint32_t j = 0; j < 4; ++j) {
      b.v[j][lane] = k < hinge_count ? mesh.hinges[k].v[j] : v.total - 1;
      b.slot[j][lane] = k < hinge_count && slots[4 * k + j] != kNone ? slots[4 * k + j] : none;
    }
    b.cosine.v[lane] = 1;
    if (k >= hinge_count) continue;
    const ClothHinge& from = mesh.hinges[k];
    const HingeFloor floor = hinge_floor(from, v.rest);
    sin_cos(from.angle, b.sine.v[lane], b.cosine.v[lane]);
    b.root.v[lane] = std::sqrt(from.stiffness);
    b.edge_floor.v[lane] = floor.edge, b.area_floor[0].v[lane] = floor.first, b.area_floor[1].v[lane] = floor.second;
  }
}

}  // namespace

Variant<ClothSolver> cloth_vbd() {
  return {"vbd", "vertex block descent: implicit Euler by sweeps over vertices, exact at rest",
          [](Arena& a, const Params& p) -> std::unique_ptr<ClothSolver> { return std::make_unique<Vbd>(a, p); }};
}

}  // namespace feder
