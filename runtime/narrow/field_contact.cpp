// Deepest first: a candidate stands when nothing deeper close by pushes another way, so that beside a corner or an edge
// only its own contact is left. Normals within some ten degrees share a manifold. Keeps nothing between calls.
// Weak spots: a contact all round, such as a thread's, is eight of its sides (with four a nut shakes off its bolt);
// samples stop at the rim of a sharp edge, up to a cell inside.
#include "narrow/field_contact.h"

#include <algorithm>
#include <cmath>

#include "feder/error.h"
#include "narrow/reduce.h"

namespace feder {
namespace {

constexpr Real kOneNormal = Real(0.985);  // cosine: one manifold
constexpr int kDescent = 10;              // steps of a descent
constexpr int kFrankWolfe = 12, kSearch = 5;

bool one_normal(const Vec3& a, const Vec3& b) { return dot(a, b) > kOneNormal; }

bool deeper(const FieldCandidate& a, const FieldCandidate& b) {
  return a.separation != b.separation ? a.separation < b.separation : a.feature < b.feature;
}

// On the way from x to s: the fraction where the field is least, for a field with one least value there.
Real search_line(const DistanceField& field, const Vec3& x, const Vec3& s) {
  // slopes at the ends, then the zero of the slope by the false position, halved where that creeps
  const Vec3 way = s - x;
  const auto slope = [&](Real t) {
    Vec3 g;
    field.at(x + t * way, g);
    return dot(g, way);
  };
  Real lo = 0, hi = 1, at_lo = slope(0), at_hi = slope(1);
  if (!(at_lo < 0)) return 0;
  if (!(at_hi > 0)) return 1;
  for (int i = 0; i < kSearch; ++i) {
    Real t = lo + (hi - lo) * at_lo / (at_lo - at_hi);
    t = std::clamp(t, lo + Real(0.1) * (hi - lo), hi - Real(0.1) * (hi - lo));
    const Real at = slope(t);
    if (at < 0)
      lo = t, at_lo = at;
    else
      hi = t, at_hi = at;
  }
  return lo + (hi - lo) * at_lo / (at_lo - at_hi);
}

}  // namespace

void NearSamples::thin(int most) {
  const auto halve = [this](Real above) {
    int kept = 0, seen = 0;
    for (int i = 0; i < count_; ++i) {
      const One s = all_[i];
      if (s.distance <= above || seen++ % 2 == 0 || s.number == deepest_number_) all_[kept++] = s;
    }
    count_ = kept;
    return seen;
  };
  while (count_ > most && halve(deepest_ + margin_ / 4) > kEnough / 4) {
  }
  while (count_ > most) halve(-kInfinity);
}

void FieldContacts::add(const FieldCandidate& c) {
  if (!(c.separation <= margin_)) return;
  if (count_ == kMost) thin_out();
  candidates_[count_++] = c;
}

void FieldContacts::add_samples(const PlacedShape& other) {
  const auto at_least = [&](const Vec3& p) { return other.at_least(p); };
  const auto distance = [&](const Vec3& p) { return other.within(p, margin_); };
  each_sample_near(field_, margin_, at_least, distance, [&](std::uint32_t i, const Sdf::Sample& s) {
    Vec3 n;
    const Real d = other.distance(s.at, n);
    if (dot(n, s.normal) <= kOpposed) add({s.at - d / 2 * n, -n, d, (i + 1) * 2654435761u});
  });
}

void FieldContacts::group(Groups& groups) {
  std::sort(candidates_, candidates_ + count_, deeper);
  groups.count = 0;
  for (int i = 0; i < count_; ++i) {
    int g = 0;
    while (g < groups.count && !one_normal(candidates_[groups.first[g]].normal, candidates_[i].normal)) ++g;
    if (g == groups.count) groups.first[groups.count++] = i;
    groups.of[i] = g;
  }
}

// What does not stand goes; groups of which nothing is left too.
void FieldContacts::drop_beside(Groups& groups) {
  const Real near = Real(1.1) * field_.sample_spacing();
  int number[kMost], kept = 0, left = 0;
  std::fill(number, number + groups.count, -1);
  for (int i = 0; i < count_; ++i) {
    bool stands = true;
    for (int k = 0; k < kept && stands; ++k)
      stands = groups.of[k] == groups.of[i] || length(candidates_[i].at - candidates_[k].at) >= near;
    if (!stands) continue;
    groups.of[kept] = groups.of[i];
    candidates_[kept++] = candidates_[i];
  }
  count_ = kept;
  for (int i = 0; i < count_; ++i) {
    int& of = number[groups.of[i]];
    if (of < 0) of = left, groups.first[left++] = i;
    groups.of[i] = of;
  }
  groups.count = left;
}

// The order in which normals count: the deepest, then that which is most unlike those before it among all that are
// nearly as deep (the walls round a peg, the flanks of a thread), then the rest by depth.
int FieldContacts::spread(const Groups& groups, int most, int* chosen) const {
  const Real near = candidates_[groups.first[0]].separation + margin_ / 4;
  bool taken[kMost] = {};
  int count = 0;
  while (count < most && count < groups.count) {
    int best = -1;
    Real unlike = -kInfinity;
    for (int g = 0; g < groups.count; ++g) {
      if (taken[g]) continue;
      const FieldCandidate& c = candidates_[groups.first[g]];
      Real value = c.separation <= near ? Real(2) : -1 - std::max(c.separation, Real(0));
      for (int k = 0; k < count && c.separation <= near; ++k)
        value = std::min(value, 1 - dot(c.normal, candidates_[groups.first[chosen[k]]].normal));
      if (value > unlike) unlike = value, best = g;
    }
    taken[best] = true;
    chosen[count++] = best;
  }
  return count;
}

// The candidates that carry a normal. A foot stands on what is down, not on its rim.
int FieldContacts::four_of(const Groups& groups, int group, int* chosen) const {
  ManifoldPoint points[kMost];
  int index[kMost], of = 0, down = 0;
  for (int k = 0; k < count_; ++k) {
    if (groups.of[k] != group) continue;
    points[of] = {candidates_[k].at, candidates_[k].separation, candidates_[k].feature};
    index[of++] = k;
  }
  FEDER_ASSERT(of > 0);
  while (down < of && points[down].separation <= points[0].separation + margin_ / 4) ++down;
  if (down >= kMaxManifoldPoints) of = down;
  const int count = reduce_indices({points, static_cast<std::size_t>(of)}, candidates_[index[0]].normal, chosen);
  for (int k = 0; k < count; ++k) chosen[k] = index[chosen[k]];
  return count;
}

// To those that stand, at most kKept: the four that carry each of eight normals.
void FieldContacts::thin_out() {
  Groups groups;
  group(groups);
  if (groups.count > 1) drop_beside(groups);
  if (count_ <= kKept) return;
  FieldCandidate out[kKept];
  int order[kKeptNormals], found = 0;
  const int normals = spread(groups, kKeptNormals, order);
  for (int n = 0; n < normals; ++n) {
    int chosen[kMaxManifoldPoints];
    const int count = four_of(groups, order[n], chosen);
    for (int k = 0; k < count; ++k) out[found++] = candidates_[chosen[k]];
  }
  std::copy(out, out + found, candidates_);
  count_ = found;
}

int FieldContacts::deepest(FieldCandidate* out, int most) const {
  int found = 0;
  const Real near = 3 * field_.sample_spacing();
  for (; found < most; ++found) {
    const FieldCandidate* best = nullptr;
    for (int i = 0; i < count_; ++i) {
      const FieldCandidate& c = candidates_[i];
      const bool apart = std::none_of(out, out + found, [&](const auto& d) { return length(c.at - d.at) < near; });
      if (apart && (!best || deeper(c, *best))) best = &c;
    }
    if (!best) break;
    out[found] = *best;
  }
  return found;
}

// The sum of the two distances has a least value where their slopes are opposite; its gradient is the sum of the
// slopes, the step is Barzilai and Borwein's (1988).
void FieldContacts::refine(const PlacedShape& other) {
  thin_out();
  const Real far = field_.sample_spacing();
  for (int i = 0; i < count_; ++i) {
    FieldCandidate& c = candidates_[i];
    Vec3 x = c.at, last_x = x, last_g = x;  // not read before they are set
    Real step = far;
    for (int k = 0; k < kDescent; ++k) {
      Vec3 na, nb;
      const Real da = field_.field().smooth_at(x, na), db = other.distance(x, nb);
      na = normalized_or(na, c.normal);
      const Vec3 n = normalized_or(na - nb, c.normal);
      if (dot(na, nb) > Real(-0.7)) break;  // an edge or a corner: no slope to follow
      const Real sum = da + db;
      if (k == 0 || sum <= c.separation) c.at = x + n * ((db - da) / 2), c.separation = sum, c.normal = n;
      Vec3 g = na + nb;
      g -= n * dot(n, g);
      if (length(g) < Real(2e-3)) break;
      if (k > 0) {
        const Vec3 dx = x - last_x, dg = g - last_g;
        const Real curved = dot(dx, dg);
        step = curved > 0 ? std::min(dot(dx, dx) / curved, 4 * far) : 2 * step;
      }
      Vec3 move = -step * g;
      if (length(move) > far) move *= far / length(move);
      last_x = c.at, last_g = g;
      x = c.at + move;
      if (length(move) < Real(2e-3) * far || length(x - c.at) > 3 * far) break;
    }
  }
  // what came to one place is one
  std::sort(candidates_, candidates_ + count_, deeper);
  int kept = 0;
  for (int i = 0; i < count_; ++i) {
    const FieldCandidate c = candidates_[i];
    if (std::none_of(candidates_, candidates_ + kept,
                     [&](const FieldCandidate& d) { return length(c.at - d.at) < Real(0.4) * far; }))
      candidates_[kept++] = c;
  }
  count_ = kept;
}

int FieldContacts::finish(const Pose& pose, Real sign, Manifold* out) {
  thin_out();
  count_ = static_cast<int>(std::remove_if(candidates_, candidates_ + count_,
                                           [&](const FieldCandidate& c) { return !(c.separation <= margin_); }) -
                            candidates_);
  if (count_ == 0) return 0;
  const Mat3 r = to_matrix(pose.rotation);
  Groups groups;
  group(groups);
  int order[kMaxManifolds];
  const int manifolds = spread(groups, kMaxManifolds, order);
  for (int n = 0; n < manifolds; ++n) {
    int chosen[kMaxManifoldPoints];
    Manifold& m = out[n];
    m.surface = 0;
    m.normal = sign * (r * candidates_[groups.first[order[n]]].normal);
    m.count = four_of(groups, order[n], chosen);
    for (int k = 0; k < m.count; ++k) {
      const FieldCandidate& c = candidates_[chosen[k]];
      m.points[k] = {pose.position + r * c.at, c.separation, c.feature};
    }
  }
  return manifolds;
}

Real least_over_convex(const DistanceField& field, const Convex& core, const Pose& place, const Vec3& start, Vec3& at,
                       Vec3& normal) {
  at = start;
  Real least = field.at(at, normal);
  const Real enough = Real(1e-4) * field.layout().spacing;
  for (int i = 0; i < kFrankWolfe; ++i) {
    const Vec3 s = to_world(place, core.support(rotate_inverse(place.rotation, -normal)));
    if (!(dot(normal, s - at) < -enough)) break;
    const Vec3 next = at + search_line(field, at, s) * (s - at);
    Vec3 slope;
    const Real d = field.at(next, slope);
    if (!(d < least)) break;
    const bool done = d > least - enough;
    least = d, at = next, normal = slope;
    if (done) break;
  }
  field.smooth_at(at, normal);
  normal = normalized_or(normal, Vec3(0, 1, 0));
  return least;
}

}  // namespace feder
