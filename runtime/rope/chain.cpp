#include "rope/chain.h"

#include <algorithm>
#include <cmath>

#include "base/trig.h"
#include "feder/error.h"
#include "rope/bend.h"

namespace feder {
namespace {

constexpr int kMaxIterations = 40;
constexpr int kFreeIterations = 5;         // in a row, with friction limits that follow the normal forces
constexpr int kHalvings = 12;              // of a correction
constexpr double kTolerance = 1e-6;        // of the segments' length: a smaller correction is the last
constexpr double kContactStiffness = 100;  // times mass/h^2 of the rope's point
constexpr double kHoopStiffness = 0.01;    // and of a segment: a rope round a post presses as it is stiff
constexpr double kSlow = 0.7;              // of the last correction: after a larger one, less is taken
constexpr double kLeastShare = 0.125;
constexpr double kDecrease = 1e-4;    // Armijo's share of what the slope promises
constexpr double kRound = 1e-13;      // of the potential: less is rounding
constexpr double kBuckling = 0.2;     // of mass/h^2: stiffness that compression may take across a segment
constexpr double kLimitError = 1e-3;  // of a friction limit

Block3 scaled_identity(double a) { return {{a, 0, 0, 0, a, 0, 0, 0, a}}; }

// a I + b u v^T
Block3 rank_one(double a, double b, const Double3& u, const Double3& v) {
  return {{a + b * u.x * v.x, b * u.x * v.y, b * u.x * v.z, b * u.y * v.x, a + b * u.y * v.y, b * u.y * v.z,
           b * u.z * v.x, b * u.z * v.y, a + b * u.z * v.z}};
}

void add_to(Block3& to, double s, const Block3& a) {
  for (int k = 0; k < 9; ++k) to.m[k] += s * a.m[k];
}

Block3 times(const Block3& a, const Block3& b) {
  Block3 c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      c.m[3 * i + j] = a.m[3 * i] * b.m[j] + a.m[3 * i + 1] * b.m[3 + j] + a.m[3 * i + 2] * b.m[6 + j];
  return c;
}

void subtract_product(Block3& from, const Block3& a, const Block3& b) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      from.m[3 * i + j] -= a.m[3 * i] * b.m[j] + a.m[3 * i + 1] * b.m[3 + j] + a.m[3 * i + 2] * b.m[6 + j];
}

Block3 inverse_of(const Block3& a) {
  const double* m = a.m;
  const double c0 = m[4] * m[8] - m[5] * m[7], c1 = m[5] * m[6] - m[3] * m[8], c2 = m[3] * m[7] - m[4] * m[6];
  const double d = 1 / (m[0] * c0 + m[1] * c1 + m[2] * c2);
  return {{d * c0, d * (m[2] * m[7] - m[1] * m[8]), d * (m[1] * m[5] - m[2] * m[4]), d * c1,
           d * (m[0] * m[8] - m[2] * m[6]), d * (m[2] * m[3] - m[0] * m[5]), d * c2, d * (m[1] * m[6] - m[0] * m[7]),
           d * (m[0] * m[4] - m[1] * m[3])}};
}

}  // namespace

void Chain::resize(std::uint32_t n) {
  for (auto* list : {&start, &target, &guess, &end_, &residual_, &pull_, &trial_}) list->resize(n, Double3{0, 0, 0});
  for (auto* list : {&diagonal_, &upper_, &upper2_, &lower_, &lower2_}) list->resize(n);
  bent_.resize(n, 0);
}

bool Chain::held(const ChainStep& s, std::uint32_t i) const { return !(s.mass[i] < double(kInfinity)); }

void Chain::add_segments(const ChainStep& s) {
  for (std::uint32_t i = 0; i + 1 < s.count; ++i) {
    const Double3 e = end_[i + 1] - end_[i];
    const double now = length(e), rest = s.rest_length[i], k = s.stretch / rest, rate = s.damping / s.h;
    const Double3 t = direction_of(e, now);
    const double force = k * (now - rest) + k * rate * (now - length(start[i + 1] - start[i]));
    const double least = -kBuckling * std::fmin(s.mass[i], s.mass[i + 1]) / (s.h * s.h);
    const double across = now > 0 && (s.mass[i] < double(kInfinity) || s.mass[i + 1] < double(kInfinity))
                              ? std::fmax(force / now, least)
                              : 0;
    const Block3 slope = rank_one(across, k * (1 + rate) - across, t, t);
    residual_[i] = residual_[i] + force * t, residual_[i + 1] = residual_[i + 1] - force * t;
    add_to(diagonal_[i], 1, slope), add_to(diagonal_[i + 1], 1, slope);
    add_to(upper_[i], -1, slope), add_to(lower_[i + 1], -1, slope);
  }
}

// The angle at a point: E I/l with l the mean length of the two segments. Of its second derivatives those of the angle
// alone (Gauss-Newton).
void Chain::add_hinge(const ChainStep& s, std::uint32_t middle) {
  const Double3 e[2] = {end_[middle] - end_[middle - 1], end_[middle + 1] - end_[middle]};
  const double l[2] = {length(e[0]), length(e[1])};
  if (!(l[0] > 0 && l[1] > 0)) return;
  const Double3 a = (1 / l[0]) * e[0], b = (1 / l[1]) * e[1];
  const Bend now = bend_between(a, b);
  const double rate = s.damping / s.h;
  const double k = now.factor * hinge_stiffness(s, middle);
  const double share = now.angle > 0 ? 1 + rate * (now.angle - bent_[middle]) / now.angle : 1;
  // derivatives of the change of direction by the three points
  const Block3 pa = rank_one(1 / l[0], -1 / l[0], a, a), pb = rank_one(1 / l[1], -1 / l[1], b, b);
  Block3 middle_block = pa;
  add_to(middle_block, 1, pb);
  for (double& x : middle_block.m) x = -x;
  const Block3* by[3] = {&pa, &middle_block, &pb};
  const Double3 pull = (-k * share) * now.change;
  const double slope = k * (1 + rate);
  const std::uint32_t first = middle - 1;
  for (std::uint32_t i = 0; i < 3; ++i) residual_[first + i] = residual_[first + i] + times(*by[i], pull);
  for (std::uint32_t i = 0; i < 3; ++i) add_to(diagonal_[first + i], slope, times(*by[i], *by[i]));
  for (std::uint32_t i = 0; i < 2; ++i) {
    add_to(upper_[first + i], slope, times(*by[i], *by[i + 1]));
    add_to(lower_[first + i + 1], slope, times(*by[i + 1], *by[i]));
  }
  add_to(upper2_[first], slope, times(pa, pb));
  add_to(lower2_[first + 2], slope, times(pb, pa));
}

// A clamped end: half a segment lies between the clamp and the middle of the first segment, so twice the stiffness.
void Chain::add_clamp(const ChainStep& s, bool last) {
  const std::uint32_t i = last ? s.count - 2 : 0;
  const Double3 e = end_[i + 1] - end_[i];
  const double l = length(e);
  if (!(l > 0)) return;
  const Double3 t = (1 / l) * e;
  const Bend now = bend_between(s.direction[last], t);
  const double rate = s.damping / s.h;
  const double k = now.factor * clamp_stiffness(s, last);
  const double share = now.angle > 0 ? 1 + rate * (now.angle - bent_[last ? s.count - 1 : 0]) / now.angle : 1;
  const Block3 p = rank_one(1 / l, -1 / l, t, t), square = times(p, p);
  const Double3 pull = times(p, (-k * share) * now.change);
  const double slope = k * (1 + rate);
  residual_[i] = residual_[i] - pull, residual_[i + 1] = residual_[i + 1] + pull;
  add_to(diagonal_[i], slope, square), add_to(diagonal_[i + 1], slope, square);
  add_to(upper_[i], -slope, square), add_to(lower_[i + 1], -slope, square);
}

void Chain::add_hinges(const ChainStep& s) {
  for (std::uint32_t i = 1; i + 1 < s.count; ++i) add_hinge(s, i);
  if (s.clamped[0]) add_clamp(s, false);
  if (s.clamped[1]) add_clamp(s, true);
}

// Force on the rope: along the normal that of the solver substep before less k times the gap, where that pushes, and
// across that of before less k' times the slide, at most friction times the normal force, or the limit where it is
// held.
bool Chain::press(const ChainStep& s, const ChainContact& c, const Array<Double3>& x, Press& out) const {
  const std::uint32_t i = c.first;
  FEDER_ASSERT((c.weight[1] != 0 ? i + 1 : i) < s.count);
  Double3 moved{0, 0, 0};
  double mass = double(kInfinity);
  for (std::uint32_t k = 0; k < 2; ++k)
    if (c.weight[k] != 0) {
      moved = moved + c.weight[k] * (x[i + k] - start[i + k]);
      mass = std::fmin(mass, s.mass[i + k]);
    }
  if (!(mass < double(kInfinity))) return false;
  const double inertia = mass / (s.h * s.h), along = s.stretch / double(s.rest_length[std::min(i, s.count - 2)]);
  out.k[0] = 1 / (1 / (kContactStiffness * inertia + kHoopStiffness * along) + c.compliance[0]);
  out.k[1] = 1 / (1 / (kContactStiffness * inertia) + c.compliance[1]);
  const double gap = c.gap + dot(c.normal, moved) + std::fmax(-c.start_gap - kPushSpeed * s.h, 0.0);
  const double before = dot(c.normal, c.force);
  out.normal = std::fmax(std::fmax(before, 0.0) - out.k[0] * gap, 0.0);
  const Double3 relative = moved - c.shift, slide = relative - dot(c.normal, relative) * c.normal;
  out.wanted = c.force - before * c.normal - out.k[1] * slide;
  out.holding = length(out.wanted);
  out.most = hold_limits_ ? c.limit : c.friction * out.normal;
  return true;
}

void Chain::add_contact(const ChainStep& s, const ChainContact& c) {
  Press p;
  if (!press(s, c, end_, p)) return;
  const bool slips = p.holding > p.most;
  const double turn = p.normal > 0 || p.most > 0 ? slips ? p.k[1] * p.most / p.holding : p.k[1] : 0;
  const Double3 force = p.normal * c.normal + (slips ? p.most / p.holding : 1) * p.wanted;
  if (!(p.normal > 0) && !(p.most > 0)) return;
  // slope: normal, and along the surface: of sticking k', of slipping friction k n^T along its force and the turn of it
  const double along = p.normal > 0 ? p.k[0] : 0;
  Block3 slope = rank_one(turn, along - turn, c.normal, c.normal);
  if (slips) {
    const Double3 d = (1 / p.holding) * p.wanted;
    add_to(slope, 1, rank_one(0, -turn, d, d));
    if (!hold_limits_) add_to(slope, 1, rank_one(0, c.friction * along, d, c.normal));
  }
  const std::uint32_t i = c.first, j = c.weight[1] != 0 ? i + 1 : i;
  residual_[i] = residual_[i] + c.weight[0] * force;
  add_to(diagonal_[i], c.weight[0] * c.weight[0], slope);
  if (j == i) return;
  residual_[j] = residual_[j] + c.weight[1] * force;
  add_to(diagonal_[j], c.weight[1] * c.weight[1], slope);
  add_to(upper_[i], c.weight[0] * c.weight[1], slope);
  add_to(lower_[j], c.weight[0] * c.weight[1], slope);
}

void Chain::finish(const ChainStep& s, ChainContact& c) const {
  Press p;
  c.pressed = 0;
  if (!press(s, c, end_, p) || !(p.normal > 0 || p.most > 0)) {
    c.force = {0, 0, 0};
    return;
  }
  c.pressed = p.normal;
  c.force = p.normal * c.normal + (p.holding > p.most ? p.most / p.holding : 1) * p.wanted;
}

// Sets friction limits by the normal forces where the rope is now; false when those of before were such, and stay.
bool Chain::renew_limits(const ChainStep& s, Array<ChainContact>& contacts) {
  bool renew = !hold_limits_;
  for (int pass = 0; pass < 2; ++pass) {
    for (ChainContact& c : contacts) {
      Press p;
      const double limit = press(s, c, end_, p) ? c.friction * p.normal : 0;
      renew = renew || std::fabs(limit - c.limit) > kLimitError * limit;
      if (pass == 1) c.limit = limit;
    }
    if (!renew) return false;
  }
  return hold_limits_ = true;
}

// Block elimination along the chain: corrections in place of residuals; answers the largest, m.
double Chain::eliminate(const ChainStep& s) {
  const std::uint32_t n = s.count;
  for (std::uint32_t i = 0; i < n; ++i) {
    const Block3 inverse = inverse_of(diagonal_[i]);
    diagonal_[i] = inverse;
    if (i + 1 < n) {
      const Block3 f = times(lower_[i + 1], inverse);
      subtract_product(diagonal_[i + 1], f, upper_[i]);
      if (wide_) subtract_product(upper_[i + 1], f, upper2_[i]);
      residual_[i + 1] = residual_[i + 1] - times(f, residual_[i]);
    }
    if (wide_ && i + 2 < n) {
      const Block3 f = times(lower2_[i + 2], inverse);
      subtract_product(lower_[i + 2], f, upper_[i]);
      subtract_product(diagonal_[i + 2], f, upper2_[i]);
      residual_[i + 2] = residual_[i + 2] - times(f, residual_[i]);
    }
  }
  double most = 0;
  for (std::uint32_t i = n; i-- > 0;) {
    Double3 r = residual_[i];
    if (i + 1 < n) r = r - times(upper_[i], residual_[i + 1]);
    if (wide_ && i + 2 < n) r = r - times(upper2_[i], residual_[i + 2]);
    residual_[i] = times(diagonal_[i], r);
    const double far = dot(residual_[i], residual_[i]);
    if (!(far <= most)) most = far;  // a NaN stays
  }
  return std::sqrt(most);
}

// Share of the correction that is taken while friction limits follow the normal forces: there is no potential then, and
// near a kink, where a contact starts to press or to slip, full corrections may go round in a circle.
double Chain::damped_share(double most) {
  const bool slow = most > (1 - share_ * (1 - kSlow)) * last_;
  if (slow) share_ = std::fmax(kSlow * share_, kLeastShare);
  last_ = most;
  return share_;
}

// With limits that are held all forces have a potential, and the correction descends: as much of it as lessens that.
double Chain::descending_share(const ChainStep& s, const Array<ChainContact>& contacts, const Array<ChainLoad>& loads,
                               double share) {
  double slope = 0;
  for (std::uint32_t i = 0; i < s.count; ++i) slope += dot(pull_[i], residual_[i]);
  const double now = potential(s, contacts, loads, end_);
  for (int k = 0; k < kHalvings; ++k, share /= 2) {
    for (std::uint32_t i = 0; i < s.count; ++i) trial_[i] = end_[i] + share * residual_[i];
    const double there = potential(s, contacts, loads, trial_);
    if (there <= now - kDecrease * share * slope + kRound * std::fabs(now)) break;
  }
  return share;
}

void Chain::assemble(const ChainStep& s, const Array<ChainContact>& contacts, const Array<ChainLoad>& loads) {
  // inertia, then forces
  for (std::uint32_t i = 0; i < s.count; ++i) {
    const double inertia = held(s, i) ? 0 : s.mass[i] / (s.h * s.h);
    diagonal_[i] = scaled_identity(inertia);
    upper_[i] = upper2_[i] = lower_[i] = lower2_[i] = scaled_identity(0);
    residual_[i] = inertia * (target[i] - end_[i]);
  }
  for (const ChainLoad& l : loads) {
    const double rate = 1 / (s.h * s.h);
    add_to(diagonal_[l.point], rate, l.mass);
    residual_[l.point] = residual_[l.point] + rate * times(l.mass, start[l.point] + l.shift - end_[l.point]);
  }
  add_segments(s);
  if (wide_) add_hinges(s);
  for (const ChainContact& c : contacts) add_contact(s, c);
  for (std::uint32_t i = 0; i < s.count; ++i) {
    if (!held(s, i)) continue;
    diagonal_[i] = scaled_identity(1);
    upper_[i] = upper2_[i] = lower_[i] = lower2_[i] = scaled_identity(0);
    residual_[i] = {0, 0, 0};
  }
}

const Array<Double3>& Chain::solve(const ChainStep& s, Array<ChainContact>& contacts, const Array<ChainLoad>& loads) {
  FEDER_ASSERT(s.count >= 2 && start.size() == s.count && s.h > 0);
  wide_ = s.bend > 0;
  double longest = 0;  // segment, m
  for (std::uint32_t i = 0; i + 1 < s.count; ++i) longest = std::fmax(longest, double(s.rest_length[i]));
  for (std::uint32_t i = 0; i < s.count; ++i) end_[i] = guess[i];
  if (wide_) remember_bends(s);
  last_ = double(kInfinity), share_ = 1, hold_limits_ = false;
  int free = 0;
  for (iterations = 1;; ++iterations) {
    if (!hold_limits_ && free++ == kFreeIterations) renew_limits(s, contacts);
    assemble(s, contacts, loads);
    if (hold_limits_)
      for (std::uint32_t i = 0; i < s.count; ++i) pull_[i] = residual_[i];
    missed = eliminate(s);
    double share = missed > longest ? longest / missed : 1;
    if (missed <= kTolerance * longest)
      share = 1;  // the last one here
    else if (hold_limits_)
      share = descending_share(s, contacts, loads, share);
    else
      share = std::fmin(share, damped_share(missed));
    for (std::uint32_t i = 0; i < s.count; ++i) end_[i] = end_[i] + share * residual_[i];
    if (iterations == kMaxIterations || !(missed < double(kInfinity))) break;
    if (missed > kTolerance * longest) continue;
    if (!hold_limits_ || !renew_limits(s, contacts)) break;
    hold_limits_ = false, free = 0, last_ = double(kInfinity), share_ = 1;  // from here, full corrections may do
  }
  for (ChainContact& c : contacts) finish(s, c);
  return end_;
}

}  // namespace feder
