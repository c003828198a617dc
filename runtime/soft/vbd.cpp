// Vertex block descent (Chen, Liu, Yang and Yuksel, "Vertex Block Descent", SIGGRAPH 2024): backward Euler by block
// coordinate descent on the incremental potential that implicit.cpp writes out. In a sweep each point moves to the
// minimum of the quadratic model of its own energy, the others held (eq. 8, 9); points of a colour share no
// tetrahedron, so a colour runs eight wide and on any thread with the same bits. First guess: along the external
// acceleration as far as elastic forces at the start leave it (section 3.7 has the acceleration of the last step there,
// which would be state to keep; the same at rest and in free fall), so a body at rest is a fixed point of any number of
// sweeps. Instead of Chebyshev weights (section 3.8) moves are over-relaxed by `relaxation`. Damping as in damping.cpp,
// less the method's own of tau = h. Sweeps keep neither momentum nor angular momentum: of a body that nothing pins both
// are put back, as a shift and as a rotation of the whole. Kept between steps: batches of the mesh. Weak spot: errors
// over many cells converge slowly, some hundred sweeps for a fine stiff body, so fast motion of one is too soft and too
// damped; rest is exact.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "base/colors.h"
#include "base/wide.h"
#include "feder/error.h"
#include "soft/batches.h"
#include "soft/descent.h"
#include "soft/stability.h"
#include "state/angular_momentum.h"

namespace feder {
namespace {

constexpr double kRatePerSweep = 3;            // h^2 w^2 that a sweep copes with
constexpr double kMostRate = 16;               // the same, of any number of sweeps
constexpr JobGrain kDescentGrain{8, 2'000};    // batches per job
constexpr JobGrain kPointsGrain{1024, 4'000};  // points per job
constexpr std::size_t kMaxSweepStages = 64;

class SoftVbd final : public SoftSolver {
 public:
  SoftVbd(Arena& a, const Params& p)
      : iterations_(p.integer({"iterations", "", {1, 10'000}}, 5)),
        relaxation_(p.real({"relaxation", "", {0, 2, true}}, 1)), batches_(a), points_(&a), tets_(&a), of_lane_(&a),
        colors_(&a), force_(&a) {
    const bool wide = wide_kernels(p);
    batches_.pick(wide);
#if defined(__x86_64__) || defined(__i386__)
    if (wide && runs_avx2()) table_ = kSoftPointsAvx2;
#endif
  }

  bool takes(const ElasticLaw& law) const override { return find(law) != nullptr; }

  // So that its sweeps reach over the waves that a solver substep resolves, and contacts bear it (implicit.cpp).
  double wanted_substeps(const SoftView& v, Real h) override {
    batches_.build(v);
    return double(h) * std::sqrt(batches_.fastest() / std::fmin(kRatePerSweep * iterations_, kMostRate));
  }

  SoftStiffness prepare(const SoftView& v, Real h, StepContext&) override {
    batches_.build(v);
    if (v.damping > h) batches_.current_position(v);
    build(v);
    kernels_ = find(*v.law);
    FEDER_ASSERT(kernels_);
    for (SoftPointBatch& b : points_)
      for (int n = 0; n < kLanes; ++n) {
        const Real w = v.delta_position[b.self[n]].w;
        b.mass.v[n] = w != 0 ? 1 / w : Real(0);
        for (unsigned k = b.first; k < b.last; ++k)
          for (int c = 0; c < 3; ++c) put(tets_[k].base[c], n, edge(v, tets_[k], b, c, n));
      }
    return {};
  }

  void advance(const SoftView& v, Real h, StepContext& c) override {
    FEDER_ASSERT(version_ == v.version && h > 0);
    step_ = h;
    const SoftPointPass p = pass(v, h);
    const auto goal = [&](std::uint32_t i) { return Vec3(v.before[i].vec() + h * v.velocity[i].vec()); };
    each_point(v, c, [&](std::uint32_t i) {
      v.before[i] = {v.delta_position[i].x, v.delta_position[i].y, v.delta_position[i].z, 0};
      if (v.delta_position[i].w != 0) v.velocity[i].add(h * expected(v, i));
    });
    for (SoftPointBatch& b : points_)
      for (int n = 0; n < kLanes; ++n) put(b.goal, n, goal(b.self[n]));
    // guess
    run(p, kernels_->begin, c);
    each_point(v, c, [&](std::uint32_t i) {
      Row4& d = v.delta_position[i];
      if (d.w == 0) return;
      d.set(goal(i) - (h * h) * held_back(expected(v, i), d.w * force_[i].vec()));
    });
    for (int k = 0; k < iterations_; ++k) run(p, kernels_->descend, c);
    for (std::uint32_t n = 0; n < v.mesh->parts(); ++n) put_back(v, v.mesh->part(n), goal);
    each_point(v, c, [&](std::uint32_t i) {
      Row4& d = v.delta_position[i];
      if (d.w != 0) {
        // contacts follow, and push it themselves
        v.velocity[i].add((d.vec() - goal(i)) / h - h * v.steady_contact[i]);
        d.add(-(h * h) * v.steady_contact[i]);
      }
      v.before[i] = {d.x, d.y, d.z, 1};
    });
  }

  void damp(const SoftView& v, Real h, StepContext& c) override {
    SoftView less = v;
    less.damping = v.damping - step_;
    if (less.damping > 0) batches_.damp(less, h, c);
  }

  void validate(const SoftView& v) const override {
    batches_.validate(v);
    if (version_ != v.version) return;
    std::uint32_t next = 0;
    for (const Range& r : colors_) {
      FEDER_ASSERT(r.first == next && r.last > r.first);
      next = r.last;
    }
    FEDER_ASSERT(next == points_.size());
    for (const SoftPointBatch& b : points_) {
      FEDER_ASSERT(b.first <= b.last && b.last <= tets_.size());
      for (const unsigned i : b.self) FEDER_ASSERT(i <= v.points);
    }
  }

 private:
  struct Range {
    std::uint32_t first, last;  // batches
  };

  const SoftPointKernels* find(const ElasticLaw& law) const {
    for (int k = 0; k < kSoftPointLaws; ++k)
      if (std::strcmp(table_[k].law, law.name) == 0) return &table_[k];
    return nullptr;
  }

  SoftPointPass pass(const SoftView& v, Real h) {
    SoftPointPass p{};
    p.batches = points_.data(), p.tets = tets_.data();
    p.delta_position = &v.delta_position->x, p.before = &v.before->x, p.force = &force_[0].x;
    p.inv_h2 = 1 / (h * h), p.relaxation = relaxation_;
    p.mu = static_cast<Real>(v.material.mu), p.lame = static_cast<Real>(v.material.lame);
    p.shear = static_cast<Real>(v.material.shear), p.lambda = static_cast<Real>(v.material.lambda);
    p.gamma = static_cast<Real>(v.material.gamma);
    return p;
  }

  template <class F>
  void each_point(const SoftView& v, StepContext& c, F&& f) {
    c.jobs->for_blocks(v.points, kPointsGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t i = first; i < last; ++i) f(i);
    });
  }

  // Colour after colour: empty lanes of each name the spare point.
  void run(const SoftPointPass& p, void (*kernel)(const SoftPointPass&), StepContext& c) {
    for_colors(colors_, kDescentGrain, stages_, *c.jobs, [&](std::uint32_t first, std::uint32_t last, int) {
      SoftPointPass part = p;
      part.first = first, part.last = last;
      kernel(part);
    });
  }

  // Acceleration from outside, that of contacts as they last were (implicit.cpp).
  static Vec3 expected(const SoftView& v, std::uint32_t i) { return v.acceleration[i] + v.steady_contact[i]; }

  static void put(Lane8x3& to, int n, const Vec3& d) { to.x.v[n] = d[0], to.y.v[n] = d[1], to.z.v[n] = d[2]; }

  // Of lanes without a tetrahedron: unit edges.
  static Vec3 edge(const SoftView& v, const SoftPointTet& t, const SoftPointBatch& b, int c, int n) {
    if (t.other[c][n] == b.self[n]) return Vec3::Unit(c);
    return v.position[t.other[c][n]] - v.position[b.self[n]];
  }

  // Part of the acceleration that the guess leaves out: what elastic forces take of it, between none and all.
  static Vec3 held_back(const Vec3& external, const Vec3& elastic) {
    const Real square = dot(external, external);
    if (!(square > 0)) return Vec3(0, 0, 0);
    return clamp(-dot(elastic, external) / square, 0, 1) * external;
  }

  // What sweeps that have not converged, and forces where the solver substep ends, add to momentum and, about where it
  // began, to angular momentum of a part that nothing holds.
  template <class F>
  void put_back(const SoftView& v, std::span<const std::uint32_t> part, F&& goal) {
    const auto place = [&](std::uint32_t k) {
      return Vec3(v.position[part[k]] - v.position[part[0]] + v.before[part[k]].vec());
    };
    const auto mass = [&](std::uint32_t k) { return 1 / v.delta_position[part[k]].w; };
    const auto count = static_cast<std::uint32_t>(part.size());
    Double3 off{0, 0, 0}, middle{0, 0, 0}, gained{0, 0, 0};  // kg m, kg m, kg m^2
    double total = 0;
    for (std::uint32_t k = 0; k < count; ++k) {
      if (v.delta_position[part[k]].w == 0) return;
      const double m = double(mass(k));
      const Double3 d = m * wide(v.delta_position[part[k]].vec() - goal(part[k])), r = wide(place(k));
      off = off + d, middle = middle + m * r, gained = gained + cross(r, d);
      total += m;
    }
    const Vec3 back = narrow((-1 / total) * off);
    for (const std::uint32_t i : part) v.delta_position[i].add(back);
    gained = gained - (1 / total) * cross(middle, off);
    take_out_spin(narrow(gained), count, static_cast<Real>(total), 0, mass, place,
                  [&](std::uint32_t k, const Vec3& change) { v.delta_position[part[k]].add(change); });
  }

  void reshape(const SoftView& v);
  void build(const SoftView& v);

  int iterations_;
  Real relaxation_;
  const SoftPointKernels *table_ = kSoftPointsPlain, *kernels_ = nullptr;
  SoftBatches batches_;  // damping
  std::uint64_t version_ = ~std::uint64_t(0), shape_ = 0;
  Array<SoftPointBatch> points_;  // by colour
  Array<SoftPointTet> tets_;      // by batch
  Array<std::uint32_t> of_lane_;  // by lane of those: the tetrahedron, or kNone
  Array<Range> colors_;
  Array<Row4> force_;  // by point, N
  JobPool::Stage stages_[kMaxSweepStages];
  Real step_ = 0;  // s, of the last solver substep
};

void SoftVbd::build(const SoftView& v) {
  if (version_ == v.version) {
    if (shape_ != v.shape) reshape(v);
    return;
  }
  version_ = v.version;
  const SoftMesh& mesh = *v.mesh;
  std::vector<std::vector<std::uint32_t>> at(v.points);  // tetrahedra by point
  for (std::uint32_t k = 0; k < mesh.tetrahedra.size(); ++k)
    for (const std::uint32_t i : mesh.tetrahedra[k]) at[i].push_back(k);
  // greedy colours: the lowest that no point of its tetrahedra has
  std::vector<std::uint32_t> color(v.points, kNone), taken;
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < v.points; ++i) {
    taken.clear();
    for (const std::uint32_t k : at[i])
      for (const std::uint32_t j : mesh.tetrahedra[k])
        if (color[j] != kNone) taken.push_back(color[j]);
    std::sort(taken.begin(), taken.end());
    std::uint32_t lowest = 0;
    for (const std::uint32_t t : taken) lowest = t == lowest ? lowest + 1 : lowest;
    color[i] = lowest;
    count = std::max(count, lowest + 1);
  }
  // batches, colour after colour; points of as many tetrahedra side by side
  points_.clear(), tets_.clear(), of_lane_.clear(), colors_.clear();
  std::vector<std::uint32_t> members;
  for (std::uint32_t n = 0; n < count; ++n) {
    members.clear();
    for (std::uint32_t i = 0; i < v.points; ++i)
      if (color[i] == n) members.push_back(i);
    std::stable_sort(members.begin(), members.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return at[a].size() > at[b].size(); });
    const auto first = static_cast<std::uint32_t>(points_.size());
    for (std::size_t from = 0; from < members.size(); from += kLanes) {
      SoftPointBatch b{};
      b.first = static_cast<unsigned>(tets_.size());
      const std::size_t most = at[members[from]].size();
      for (std::size_t lane = 0; lane < kLanes; ++lane)
        b.self[lane] = from + lane < members.size() ? members[from + lane] : v.points;
      for (std::size_t k = 0; k < most; ++k) {
        SoftPointTet t{};
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
          const std::uint32_t i = b.self[lane];
          for (auto& other : t.other) other[lane] = i;
          t.gradient[0].x.v[lane] = t.gradient[1].y.v[lane] = t.gradient[2].z.v[lane] = 1;
          of_lane_.push_back(i < v.points && k < at[i].size() ? at[i][k] : kNone);
          const std::uint32_t tet = of_lane_.back();
          if (tet == kNone) continue;
          const TetrahedronPoints& corners = mesh.tetrahedra[tet];
          t.volume.v[lane] = mesh.volume[tet];
          std::size_t next = 0;
          for (const std::uint32_t j : corners)
            if (j != i) t.other[next++][lane] = j;
        }
        tets_.push_back(t);
      }
      b.last = static_cast<unsigned>(tets_.size());
      points_.push_back(b);
    }
    colors_.push_back({first, static_cast<std::uint32_t>(points_.size())});
  }
  force_.assign(std::size_t(v.points) + 1, Row4{});
  reshape(v);
}

// Gradients of the other corners' weights, as they are now.
void SoftVbd::reshape(const SoftView& v) {
  shape_ = v.shape;
  const SoftMesh& mesh = *v.mesh;
  for (const SoftPointBatch& b : points_)
    for (std::size_t n = std::size_t(b.first) * kLanes; n < std::size_t(b.last) * kLanes; ++n) {
      const std::uint32_t tet = of_lane_[n];
      if (tet == kNone) continue;
      const Real* rows = &mesh.inverse[9 * std::size_t(tet)];
      const auto row = [&](std::size_t c) { return Vec3(rows[3 * c - 3], rows[3 * c - 2], rows[3 * c - 1]); };
      const std::size_t lane = n % kLanes;
      std::size_t next = 0;
      for (std::size_t c = 0; c < 4; ++c)
        if (mesh.tetrahedra[tet][c] != b.self[lane])
          put(tets_[n / kLanes].gradient[next++], static_cast<int>(lane),
              c > 0 ? row(c) : Vec3(-row(1) - row(2) - row(3)));
    }
}

}  // namespace

Variant<SoftSolver> soft_vbd() {
  return {"vbd", "vertex block descent: backward Euler by sweeps over points, exact at rest",
          [](Arena& a, const Params& p) -> std::unique_ptr<SoftSolver> { return std::make_unique<SoftVbd>(a, p); }};
}

}  // namespace feder
