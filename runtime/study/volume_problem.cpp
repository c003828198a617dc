#include "study/volume_problem.h"

#include <algorithm>
#include <cmath>

#include "base/rng.h"

namespace feder {
namespace {

constexpr int kSteps = 32;

}  // namespace

void VolumeProblem::set_items(ProblemOptions& o) {
  const int count = o.integer("items", 60, 2, 20000, "thin boxes");
  const double slender = o.number("slender", 6, 1, 1000, "length of a box over its thickness");
  const double crowd = o.number("crowd", 1, 0.01, 100, "boxes per cubic box length");
  info_.t_end = 1, info_.dof = 3 * count;
  const double side = std::cbrt(count / crowd);
  Rng rng(12);
  for (int i = 0; i < count; ++i) {
    const auto any = [&](double half) { return rng.uniform(static_cast<Real>(-half), static_cast<Real>(half)); };
    centers_.emplace_back(any(side / 2), any(side / 2), any(side / 2));
    velocities_.emplace_back(any(1), any(1), any(1));
    const Quat q = normalized(Quat{any(1), any(1), any(1), any(1)});
    const Real thin = static_cast<Real>(0.5 / slender);
    Mat3 e;
    e.col(0) = rotate(q, Vec3(Real(0.5), 0, 0)), e.col(1) = rotate(q, Vec3(0, i % 2 ? Real(0.5) : thin, 0));
    e.col(2) = rotate(q, Vec3(0, 0, thin));
    edges_.push_back(e);
  }
  info_.x_scale = side, info_.v_scale = 1;
  set_reference(ReferenceKind::quad, 15, 1e-7, "separating axes of the convex hulls, all pairs");
}

std::vector<RunSpec> VolumeProblem::ladder(const MethodInfo& method) const {
  std::vector<RunSpec> all;
  for (const std::string& value : rungs_) {
    RunSpec spec;
    spec.method = method.name, spec.steps = kSteps;
    spec.settings = {{rung_name_, value}};
    all.push_back(spec);
  }
  return all;
}

void VolumeProblem::place(double t, std::vector<Vec3>& points) const {
  points.clear();
  for (std::size_t i = 0; i < centers_.size(); ++i) {
    const Vec3 at = centers_[i] + static_cast<Real>(t) * velocities_[i];
    for (int k = 0; k < 8; ++k) {
      Vec3 p = at;
      for (int d = 0; d < 3; ++d) p += (k >> d & 1 ? Real(1) : Real(-1)) * edges_[i].col(d);
      points.push_back(p);
    }
  }
}

void VolumeProblem::reference(double t, Observation& out) const {
  out = {};
  for (std::size_t i = 0; i < centers_.size(); ++i) {
    const Vec3 at = centers_[i] + static_cast<Real>(t) * velocities_[i];
    for (int k = 0; k < 3; ++k)
      out.x.push_back(static_cast<double>(at[k])), out.v.push_back(static_cast<double>(velocities_[i][k]));
  }
}

const ItemPairs& VolumeProblem::truth(double t) const {
  for (const auto& [time, pairs] : known_)
    if (time == t) return pairs;
  std::vector<Vec3> points;
  place(t, points);
  const ItemPoints all{points, 8};
  std::vector<std::unique_ptr<BoundingVolume>> hulls;
  for (std::uint32_t i = 0; i < all.count(); ++i) hulls.push_back(bounding_volume("hull").around({all.of(i), 8}));
  ItemPairs pairs;
  for (std::uint32_t a = 0; a < hulls.size(); ++a)
    for (std::uint32_t b = a + 1; b < hulls.size(); ++b)
      if (hulls[a]->overlaps(*hulls[b])) pairs.emplace_back(a, b);
  return known_.emplace_back(t, std::move(pairs)).second;
}

void VolumeRun::step() {
  t_ += h_, ++count_.steps;
  problem_.place(t_, points_);
  found_.clear();
  find({points_, 8}, found_, tests_);
  count_.force_evals = tests_ / static_cast<std::int64_t>(problem_.items());
  in_all_ += found_.size();
  counts_.emplace_back(t_, found_.size());
}

void VolumeRun::observe(Observation& out) { problem_.reference(t_, out); }

Invariants VolumeRun::invariants() {
  Invariants i;
  if (count_.steps == 0) return i;
  const ItemPairs& truth = problem_.truth(t_);
  ItemPairs found = found_;
  std::sort(found.begin(), found.end());
  std::size_t missed = 0;
  for (const auto& pair : truth) missed += !std::binary_search(found.begin(), found.end(), pair);
  i.constraint = truth.empty() ? 0 : static_cast<double>(missed) / static_cast<double>(truth.size());
  return i;
}

double VolumeRun::own_error() const {
  std::size_t touching = 0;
  for (const auto& [t, found] : counts_) touching += problem_.truth(t).size();
  return in_all_ == 0 ? 0 : 1 - std::min(1.0, static_cast<double>(touching) / static_cast<double>(in_all_));
}

}  // namespace feder
