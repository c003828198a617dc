#include "contact/flat_parts.h"

#include <algorithm>
#include <cmath>

#include "base/checks.h"
#include "base/wide.h"
#include "bounds/box_query.h"

namespace feder {
namespace {

constexpr int kBlockCells = 4;            // mean edges along the side of a block
constexpr int kMostBlocks = 64;           // along a side
constexpr Real kSure = Real(0.5);         // least share of a distance at rest that is kept: sheets bend by 60 degrees
constexpr Real kFlatness = Real(1e-4);    // of the extent: how far points of a flat rest shape lie from its plane
constexpr Real kCovered = Real(1e-3);     // error of the area of a window that is covered once
constexpr Real kInside = Real(1e-3);      // of the longest edge: how far a border is inside of a window
constexpr JobGrain kMeasure{16, 20'000};  // blocks per job

Vec3 in_plane(const Vec3& n) {  // a unit vector across n
  const Vec3 a = std::abs(n[0]) < Real(0.6) ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  return normalized_or(cross(n, a), Vec3(0, 0, 1));
}

struct Rectangle {
  Real lo[2], hi[2];
  Real area() const { return std::max(hi[0] - lo[0], Real(0)) * std::max(hi[1] - lo[1], Real(0)); }
};

// Area of a triangle within a rectangle (Sutherland and Hodgman 1974).
Real area_within(const Real (&t)[3][2], const Rectangle& r) {
  Real from[8][2], to[8][2];
  int n = 3;
  for (int k = 0; k < 3; ++k) from[k][0] = t[k][0], from[k][1] = t[k][1];
  for (int side = 0; side < 4 && n > 0; ++side) {
    const int axis = side / 2;
    const bool low = side % 2 == 0;
    const auto depth = [&](const Real(&p)[2]) { return low ? p[axis] - r.lo[axis] : r.hi[axis] - p[axis]; };
    int kept = 0;
    for (int k = 0; k < n; ++k) {
      const Real(&a)[2] = from[k], (&b)[2] = from[(k + 1) % n];
      const Real da = depth(a), db = depth(b);
      if (da >= 0) to[kept][0] = a[0], to[kept][1] = a[1], ++kept;
      if ((da >= 0) != (db >= 0)) {
        const Real s = da / (da - db);
        to[kept][0] = a[0] + s * (b[0] - a[0]), to[kept][1] = a[1] + s * (b[1] - a[1]), ++kept;
      }
    }
    n = kept;
    for (int k = 0; k < n; ++k) from[k][0] = to[k][0], from[k][1] = to[k][1];
  }
  Real twice = 0;
  for (int k = 0; k < n; ++k) {
    const int next = (k + 1) % n;
    twice += from[k][0] * from[next][1] - from[next][0] * from[k][1];
  }
  return std::abs(twice) / 2;
}

// Whether a segment passes through the inside of a rectangle (Liang and Barsky 1984).
bool passes(const Real (&a)[2], const Real (&b)[2], const Rectangle& r) {
  Real enter = 0, leave = 1;
  for (int k = 0; k < 2; ++k) {
    const Real d = b[k] - a[k];
    if (d == 0) {
      if (a[k] <= r.lo[k] || a[k] >= r.hi[k]) return false;
      continue;
    }
    const Real s = (r.lo[k] - a[k]) / d, t = (r.hi[k] - a[k]) / d;
    enter = std::max(enter, std::min(s, t)), leave = std::min(leave, std::max(s, t));
  }
  return enter < leave;
}

// The orthonormal columns nearest to those given, F (F^T F)^(-1/2); false where they are nearly parallel.
bool nearest_frame(const Vec3& a, const Vec3& b, Vec3 (&e)[2]) {
  const Real aa = dot(a, a), bb = dot(b, b), ab = dot(a, b), det = aa * bb - ab * ab;
  if (!(det > Real(1e-4) * aa * bb)) return false;
  const Real s = std::sqrt(det), t = std::sqrt(aa + bb + 2 * s);
  // the inverse of the root (S + s I)/t
  const Real scale = t / ((aa + s) * (bb + s) - ab * ab);
  e[0] = scale * ((bb + s) * a - ab * b), e[1] = scale * ((aa + s) * b - ab * a);
  return true;
}

}  // namespace

FlatParts::FlatParts(Arena& a)
    : block_of_(&a), flat_(&a), triangles_(&a), first_(&a), own_(&a), round_(a), corners_(a), batches_(&a),
      first_batch_(&a), gradients_(&a), at_(&a), way_(&a), list_(&a), points_(a), edges_(a), faces_(a), sure_(&a),
      nodes_(&a), meeting_(&a), some_{Some(a), Some(a)}, hits_(&a) {
#if defined(__x86_64__) || defined(__i386__)
  if (runs_avx2()) kernels_ = &kFlatKernelsAvx2;
#endif
}

void FlatParts::build(const Surface& s) {
  if (version_ == s.version && object_ == s.object) return;
  object_ = s.object, version_ = s.version, blocks_ = 0, heights_ = 0;
  if (!s.rest || !s.borders || s.triangles.size() < 6) return;
  // the plane of the rest shape
  Vec3 normal = Vec3::Zero();
  Aabb box;
  for (std::uint32_t i = 0; i < s.count; ++i) box.include(s.rest[i]);
  const auto twice_area = [&](std::size_t k) {
    const std::uint32_t* t = &s.triangles[k];
    return cross(Vec3(s.rest[t[1]] - s.rest[t[0]]), Vec3(s.rest[t[2]] - s.rest[t[0]]));
  };
  for (std::size_t k = 0; k < s.triangles.size(); k += 3) normal += twice_area(k);
  const Vec3 n = normalized_or(normal, Vec3(0, 1, 0)), extent = box.hi - box.lo;
  const Real all = length(extent);
  for (std::uint32_t i = 0; i < s.count; ++i)
    if (!(std::abs(dot(n, Vec3(s.rest[i] - s.rest[0]))) < kFlatness * all)) return;
  for (std::size_t k = 0; k < s.triangles.size(); k += 3)
    if (!(dot(n, twice_area(k)) > 0)) return;
  // along the sides of the box where that lies in the plane, as sheets do
  Vec3 axis[2];
  const int thin = std::abs(n[0]) > Real(0.999) ? 0 : std::abs(n[1]) > Real(0.999) ? 1 : 2;
  axis[0] = std::abs(n[thin]) > Real(0.999) ? Vec3::Unit((thin + 1) % 3) : in_plane(n);
  axis[1] = cross(n, axis[0]);
  list_triangles(s, axis);
}

// Coordinates, blocks and triangles.
void FlatParts::list_triangles(const Surface& s, const Vec3 (&axis)[2]) {
  flat_.resize(2 * s.count), block_of_.resize(s.count);
  for (int k = 0; k < 2; ++k) lo_[k] = kInfinity, hi_[k] = -kInfinity;
  for (std::uint32_t i = 0; i < s.count; ++i)
    for (int k = 0; k < 2; ++k) {
      const Real at = dot(axis[k], Vec3(s.rest[i] - s.rest[0]));
      flat_[2 * i + static_cast<std::uint32_t>(k)] = at;
      lo_[k] = std::min(lo_[k], at), hi_[k] = std::max(hi_[k], at);
    }
  Real sum = 0, longest = 0;
  triangles_.resize(s.triangles.size() / 3);
  for (std::size_t k = 0; k < triangles_.size(); ++k) {
    Triangle& t = triangles_[k];
    Real e[3][2];
    for (std::size_t c = 0; c < 3; ++c) t.v[c] = s.triangles[3 * k + c];
    for (std::size_t c = 0; c < 3; ++c)
      for (std::uint32_t d = 0; d < 2; ++d) e[c][d] = flat_[2 * t.v[(c + 1) % 3] + d] - flat_[2 * t.v[c] + d];
    const Real det = e[0][1] * e[2][0] - e[0][0] * e[2][1];  // edges 0 and -2
    t.area = det / 2;
    if (!(t.area > 0)) return;
    t.inverse[0] = -e[2][1] / det, t.inverse[1] = e[2][0] / det;
    t.inverse[2] = -e[0][1] / det, t.inverse[3] = e[0][0] / det;
    t.heights = 0;
    for (const auto& edge : e) {
      const Real side = std::sqrt(edge[0] * edge[0] + edge[1] * edge[1]);
      t.heights += side / det, sum += side, longest = std::max(longest, side);
    }
  }
  const Real mean = sum / static_cast<Real>(3 * triangles_.size());
  const Real size = std::max(kBlockCells * mean, std::max(hi_[0] - lo_[0], hi_[1] - lo_[1]) / kMostBlocks);
  const auto blocks = [&](int k) { return std::max(1, static_cast<int>(std::floor((hi_[k] - lo_[k]) / size))); };
  nx_ = blocks(0), ny_ = blocks(1);
  const auto place = [&](std::uint32_t i, int k, int n) {
    const Real at = (flat_[2 * i + static_cast<std::uint32_t>(k)] - lo_[k]) / (hi_[k] - lo_[k]);
    return std::clamp(static_cast<int>(at * static_cast<Real>(n)), 0, n - 1);
  };
  for (std::uint32_t i = 0; i < s.count; ++i)
    block_of_[i] = static_cast<std::uint32_t>(place(i, 0, nx_) + nx_ * place(i, 1, ny_));
  blocks_ = static_cast<std::uint32_t>(nx_ * ny_);
  for (levels_ = 1; levels_ < kLevels && (std::max(nx_, ny_) - 1) >> levels_ > 0;) ++levels_;
  for (int level = 0; level < levels_; ++level)
    first_node_[level + 1] = first_node_[level] + static_cast<std::size_t>(wide(level) * high(level));
  sure_.resize(first_node_[levels_]);
  list_.resize(blocks_);
  check_covers(s, longest);
  list_features(points_, 1, [&](auto&& f) {
    for (std::uint32_t i = 0; i < s.count; ++i) f(&i);
  });
  list_features(faces_, 3, [&](auto&& f) {
    for (std::size_t k = 0; k < s.triangles.size(); k += 3) f(&s.triangles[k]);
  });
  list_features(edges_, 2, [&](auto&& f) {
    const std::uint32_t* ends = s.edges.ends;
    for (std::uint32_t e = 0; e < s.edges.count; ++e, ends += s.edges.stride) f(ends);
  });
  list_batches();
  list_points(round_, [&](std::uint32_t b, auto&& f) {
    for (std::uint32_t k = first_[b]; k < first_[b + 1]; ++k)
      for (const std::uint32_t i : triangles_[own_[k]].v) f(i);
  });
  list_points(corners_, [&](std::uint32_t b, auto&& f) {
    for (const Features* of : {&points_, &faces_, &edges_})
      for (std::uint32_t k = of->points * of->first[b]; k < of->points * of->first[b + 1]; ++k) f(of->v[k]);
  });
  at_.resize(s.count), way_.resize(s.count);
}

// Each point of a block once, in the order of their numbers.
template <class Each>
void FlatParts::list_points(Points& p, Each&& each) {
  p.first.assign(blocks_ + 1, 0), p.point.clear();
  for (std::uint32_t b = 0; b < blocks_; ++b) {
    const auto begin = static_cast<std::ptrdiff_t>(p.point.size());
    each(b, [&](std::uint32_t i) { p.point.push_back(i); });
    std::sort(p.point.begin() + begin, p.point.end());
    p.point.erase(std::unique(p.point.begin() + begin, p.point.end()), p.point.end());
    p.first[b + 1] = static_cast<std::uint32_t>(p.point.size());
  }
}

void FlatParts::list_batches() {
  batches_.clear(), first_batch_.assign(blocks_ + 1, 0), most_batches_ = 0;
  for (std::uint32_t b = 0; b < blocks_; ++b) {
    for (std::uint32_t k = first_[b]; k < first_[b + 1]; k += kLanes) {
      FlatBatch& batch = batches_.emplace_back();
      for (std::uint32_t i = 0; i < kLanes; ++i) {
        const bool whole = k + i < first_[b + 1];
        const Triangle& t = triangles_[own_[whole ? k + i : k]];
        for (int c = 0; c < 3; ++c) batch.v[c][i] = t.v[c];
        for (int c = 0; c < 4; ++c) batch.inverse[c].v[i] = t.inverse[c];
        batch.area.v[i] = whole ? t.area : Real(0);
      }
    }
    first_batch_[b + 1] = static_cast<std::uint32_t>(batches_.size());
    most_batches_ = std::max(most_batches_, first_batch_[b + 1] - first_batch_[b]);
  }
}

template <class Each>
void FlatParts::list_features(Features& f, std::uint32_t points, Each&& each) {
  f.points = points;
  f.first.assign(blocks_ + 1, 0);
  each([&](const std::uint32_t* v) { ++f.first[block_of_[v[0]] + 1]; });
  for (std::uint32_t b = 0; b < blocks_; ++b) f.first[b + 1] += f.first[b];
  const std::uint32_t count = f.first[blocks_];
  f.v.resize(points * count);
  f.box.resize(count), f.all.resize(blocks_);
  each([&](const std::uint32_t* v) {
    const std::uint32_t at = f.first[block_of_[v[0]]]++;
    std::copy(v, v + points, f.v.begin() + points * at);
  });
  for (std::uint32_t b = blocks_; b > 0; --b) f.first[b] = f.first[b - 1];
  f.first[0] = 0;
}

// Triangles of the grown squares of blocks, and whether those are covered once, without a border inside.
void FlatParts::check_covers(const Surface& s, Real reach) {
  const Real side[2] = {(hi_[0] - lo_[0]) / static_cast<Real>(nx_), (hi_[1] - lo_[1]) / static_cast<Real>(ny_)};
  const auto square = [&](std::uint32_t b, Real grow) {
    const int at[2] = {static_cast<int>(b) % nx_, static_cast<int>(b) / nx_};
    Rectangle r;
    for (int k = 0; k < 2; ++k) {
      const Real lo = lo_[k] + side[k] * static_cast<Real>(at[k]);
      r.lo[k] = std::max(lo - grow, lo_[k]), r.hi[k] = std::min(lo + side[k] + grow, hi_[k]);
    }
    return r;
  };
  // f(block) for the blocks whose grown squares a box in the plane meets
  const auto each_block = [&](const Real(&lo)[2], const Real(&hi)[2], auto&& f) {
    int first[2], last[2];
    for (int k = 0; k < 2; ++k) {
      const int n = k == 0 ? nx_ : ny_;
      first[k] = std::clamp(static_cast<int>(std::floor((lo[k] - reach - lo_[k]) / side[k])), 0, n - 1);
      last[k] = std::clamp(static_cast<int>(std::floor((hi[k] + reach - lo_[k]) / side[k])), 0, n - 1);
    }
    for (int j = first[1]; j <= last[1]; ++j)
      for (int i = first[0]; i <= last[0]; ++i) f(static_cast<std::uint32_t>(i + nx_ * j));
  };
  const auto each_pair = [&](auto&& f) {  // f(block, triangle)
    for (std::uint32_t k = 0; k < triangles_.size(); ++k) {
      Real lo[2], hi[2];
      for (std::uint32_t d = 0; d < 2; ++d) {
        const Real a = flat_[2 * triangles_[k].v[0] + d], b = flat_[2 * triangles_[k].v[1] + d],
                   c = flat_[2 * triangles_[k].v[2] + d];
        lo[d] = std::min({a, b, c}), hi[d] = std::max({a, b, c});
      }
      each_block(lo, hi, [&](std::uint32_t b) { f(b, k); });
    }
  };
  first_.assign(blocks_ + 1, 0);
  each_pair([&](std::uint32_t b, std::uint32_t) { ++first_[b + 1]; });
  for (std::uint32_t b = 0; b < blocks_; ++b) first_[b + 1] += first_[b];
  own_.resize(first_[blocks_]);
  each_pair([&](std::uint32_t b, std::uint32_t k) { own_[first_[b]++] = k; });
  for (std::uint32_t b = blocks_; b > 0; --b) first_[b] = first_[b - 1];
  first_[0] = 0;

  for (std::uint32_t b = 0; b < blocks_; ++b) {
    const Rectangle r = square(b, reach);
    Real covered = 0;
    list_[b] = Block();
    for (std::uint32_t k = first_[b]; k < first_[b + 1]; ++k) {
      Real corner[3][2];
      for (std::size_t c = 0; c < 3; ++c)
        for (std::uint32_t d = 0; d < 2; ++d) corner[c][d] = flat_[2 * triangles_[own_[k]].v[c] + d];
      covered += area_within(corner, r);
      list_[b].heights = std::max(list_[b].heights, triangles_[own_[k]].heights);
    }
    heights_ = std::max(heights_, list_[b].heights);
    list_[b].covered = std::abs(covered - r.area()) < kCovered * r.area();
  }
  // edges of one triangle alone
  const std::uint32_t* ends = s.edges.ends;
  const std::uint32_t* sides = s.borders;
  for (std::uint32_t e = 0; e < s.edges.count; ++e, ends += s.edges.stride, sides += s.edges.stride) {
    if (*sides != kNone) continue;
    Real p[2][2], lo[2], hi[2];
    for (std::uint32_t d = 0; d < 2; ++d) {
      p[0][d] = flat_[2 * ends[0] + d], p[1][d] = flat_[2 * ends[1] + d];
      lo[d] = std::min(p[0][d], p[1][d]), hi[d] = std::max(p[0][d], p[1][d]);
    }
    each_block(lo, hi, [&](std::uint32_t b) {
      Rectangle r = square(b, reach);
      for (int d = 0; d < 2; ++d) r.lo[d] += kInside * reach, r.hi[d] -= kInside * reach;
      if (passes(p[0], p[1], r)) list_[b].covered = false;
    });
  }
}

// Frame and certificate of a block.
void FlatParts::measure_block(std::uint32_t block, const Motion& m, int worker) {
  Block& b = list_[block];
  b.least = -1, b.largest = b.deviation = 0;
  for (const std::uint32_t i : round_.of(block)) b.deviation = std::max(b.deviation, m.deviation[i]);
  if (m.final && !(b.deviation * b.heights < 1)) return;  // nothing that is not stretched could bear that
  FlatPass p{};
  p.batches = batches_.data() + first_batch_[block], p.count = first_batch_[block + 1] - first_batch_[block];
  p.gradients = gradients_.data() + static_cast<std::size_t>(worker) * most_batches_;
  p.at = &at_[0].x, p.way = &way_[0].x;
  kernels_->gradients(p);
  const Vec3 sum[2] = {{p.sum[0][0], p.sum[0][1], p.sum[0][2]}, {p.sum[1][0], p.sum[1][1], p.sum[1][2]}};
  if (!nearest_frame(sum[0], sum[1], b.frame.e)) return;
  for (int n = 0; n < 2; ++n)
    for (int k = 0; k < 3; ++k) p.frame[n][k] = b.frame.e[n][k];
  kernels_->test(p);
  b.least = p.least, b.largest = std::sqrt(p.largest);
}

void FlatParts::measure(const Motion& m, JobPool& jobs) {
  FEDER_ASSERT(flat() && m.time >= 0);
  motion_ = m;
  for (std::size_t i = 0; i < at_.size(); ++i) at_[i].set(m.x[i]), way_[i].set(m.time * m.v[i]);
  gradients_.resize(static_cast<std::size_t>(jobs.threads()) * most_batches_);
  jobs.for_blocks(blocks_, kMeasure, [&](std::uint32_t first, std::uint32_t last, int worker) {
    for (std::uint32_t b = first; b < last; ++b)
      if (list_[b].covered) measure_block(b, m, worker);
  });
}

// Certificate of the window of 2^(level + 1) blocks along each side whose first is 2^level times (i, j).
Real FlatParts::window(int level, int i, int j, Real most) const {
  const int first[2] = {i << level, j << level}, n[2] = {nx_, ny_};
  int last[2];
  for (int k = 0; k < 2; ++k) last[k] = std::min(first[k] + (2 << level), n[k]);
  const auto each = [&](auto&& f) {
    for (int y = first[1]; y < last[1]; ++y)
      for (int x = first[0]; x < last[0]; ++x)
        if (!f(list_[static_cast<std::size_t>(x + nx_ * y)])) return false;
    return true;
  };
  const auto own = [&](const Block& b) { return b.least - std::min(b.deviation, most) * b.heights; };
  Vec3 sum[2] = {Vec3::Zero(), Vec3::Zero()}, e[2];
  const bool good = each([&](const Block& b) {
    sum[0] += b.frame.e[0], sum[1] += b.frame.e[1];
    return b.covered && own(b) > kSure;
  });
  if (!good || !nearest_frame(sum[0], sum[1], e)) return -1;
  Real least = kInfinity;
  each([&](const Block& b) {
    const Vec3 d0 = e[0] - b.frame.e[0], d1 = e[1] - b.frame.e[1];
    least = std::min(least, own(b) - std::sqrt(dot(d0, d0) + dot(d1, d1)) * b.largest);
    return least > kSure;
  });
  return least;
}

bool FlatParts::decide(Real most) {
  FEDER_ASSERT(flat() && most >= 0);
  for (int level = levels_ - 1; level >= 0; --level) {
    for (int j = 0; j < high(level); ++j)
      for (int i = 0; i < wide(level); ++i) sure_[node(level, i, j)] = window(level, i, j, most) > kSure;
    if (level == levels_ - 1 && sure_[node(level, 0, 0)]) return true;
  }
  return false;
}

Real FlatParts::sure_share() const {
  const std::size_t count = static_cast<std::size_t>(wide(0)) * static_cast<std::size_t>(high(0));
  const auto first = sure_.begin() + static_cast<std::ptrdiff_t>(first_node_[0]);
  return static_cast<Real>(std::count(first, first + static_cast<std::ptrdiff_t>(count), 1)) / static_cast<Real>(count);
}

// Whether a window of this level with a certificate holds both nodes.
bool FlatParts::apart(int level, int ax, int ay, int bx, int by) const {
  if (std::abs(ax - bx) > 1 || std::abs(ay - by) > 1) return false;
  for (int j = std::max(std::max(ay, by) - 1, 0); j <= std::min(ay, by); ++j)
    for (int i = std::max(std::max(ax, bx) - 1, 0); i <= std::min(ax, bx); ++i)
      if (sure_[node(level, i, j)]) return true;
  return false;
}

namespace {

// Whether two boxes in motion come within `margin` of each other, as far as single axes tell.
bool meet_in(const Aabb& a, const Aabb& va, const Aabb& b, const Aabb& vb, Real time, Real margin) {
  Real enter = 0, leave = time;
  for (int k = 0; k < 3; ++k) {
    // the gap on either side, which closes with the fastest points: gap + t u <= 0
    const Real gap[2] = {a.lo[k] - b.hi[k] - margin, b.lo[k] - a.hi[k] - margin};
    const Real u[2] = {va.lo[k] - vb.hi[k], vb.lo[k] - va.hi[k]};
    for (int side = 0; side < 2; ++side) {
      if (u[side] < 0)
        enter = std::max(enter, gap[side] / -u[side]);
      else if (u[side] > 0)
        leave = std::min(leave, -gap[side] / u[side]);
      else if (gap[side] > 0)
        return false;
    }
    if (!(enter <= leave)) return false;
  }
  return true;
}

}  // namespace

void FlatParts::find_meeting(Real margin) {
  // bounds of blocks, then of the nodes above
  Real most = 0;
  nodes_.assign(first_node_[levels_], Node());
  for (std::uint32_t b = 0; b < blocks_; ++b) {
    Node& n = nodes_[b];
    for (const std::uint32_t i : corners_.of(b)) n.box.include(motion_.x[i]), n.motion.include(motion_.v[i]);
    list_[b].boxed = false;
    list_[b].drift = Vec3::Zero();
    const std::uint32_t first = points_.first[b], last = points_.first[b + 1];
    for (std::uint32_t k = first; k < last; ++k) {
      list_[b].drift += motion_.v[points_.v[k]];
      most = std::max(most, motion_.deviation[points_.v[k]]);
    }
    if (last > first) list_[b].drift /= static_cast<Real>(last - first);
  }
  for (int level = 1; level < levels_; ++level) {
    for (int j = 0; j < high(level - 1); ++j)
      for (int i = 0; i < wide(level - 1); ++i) {
        const Node& from = nodes_[node(level - 1, i, j)];
        Node& to = nodes_[node(level, i / 2, j / 2)];
        to.box.include(from.box), to.motion.include(from.motion);
      }
  }
  meeting_.clear();
  const int top = levels_ - 1;
  const int count = wide(top) * high(top);
  for (int a = 0; a < count; ++a)
    for (int b = a; b < count; ++b)
      descend(top, a % wide(top), a / wide(top), b % wide(top), b / wide(top), margin + 2 * most);
}

// Pairs of blocks under two nodes, or one, that may meet.
void FlatParts::descend(int level, int ax, int ay, int bx, int by, Real margin) {
  const auto at = [&](int x, int y) { return static_cast<std::uint32_t>(x + wide(level) * y); };
  const Node &a = nodes_[node(level, ax, ay)], &b = nodes_[node(level, bx, by)];
  if (a.box.empty() || b.box.empty() || !meet_in(a.box, a.motion, b.box, b.motion, motion_.time, margin)) return;
  if (apart(level, ax, ay, bx, by)) return;
  if (level == 0) return meeting_.push_back({at(ax, ay), at(bx, by)});
  const bool same = ax == bx && ay == by;
  const auto inside = [&](int x, int y) { return x < wide(level - 1) && y < high(level - 1); };
  for (int p = 0; p < 4; ++p)
    for (int q = same ? p : 0; q < 4; ++q) {
      const int px = 2 * ax + p % 2, py = 2 * ay + p / 2, qx = 2 * bx + q % 2, qy = 2 * by + q / 2;
      if (inside(px, py) && inside(qx, qy)) descend(level - 1, px, py, qx, qy, margin);
    }
}

// Swept boxes of the features of a block, beside its drift, each grown by half of what matters.
void FlatParts::box_features(std::uint32_t block, Features& f, Real margin) {
  const Vec3& drift = list_[block].drift;
  Aabb& all = f.all[block];
  all = Aabb();
  for (std::uint32_t k = f.first[block]; k < f.first[block + 1]; ++k) {
    Aabb& box = f.box[k];
    box = Aabb();
    Real off = 0;
    for (std::uint32_t c = 0; c < f.points; ++c) {
      const std::uint32_t i = f.v[f.points * k + c];
      box.include(motion_.x[i]), box.include(Vec3(motion_.x[i] + motion_.time * (motion_.v[i] - drift)));
      off = std::max(off, motion_.deviation[i]);
    }
    box.grow(off + margin / 2);
    all.include(box);
  }
}

namespace {

// Where a box may be that goes by `way`.
Aabb swept(Aabb box, const Vec3& way) {
  box.lo += way.cwiseMin(Vec3::Zero()), box.hi += way.cwiseMax(Vec3::Zero());
  return box;
}

}  // namespace

void FlatParts::pick(const Features& f, std::uint32_t block, const Aabb& box, const Vec3& apart, Some& out) {
  const BoxQuery query(swept(box, apart));
  for_each_of([](auto& array) { array.clear(); }, out.item, out.box, out.run);
  for (std::uint32_t k = f.first[block]; k < f.first[block + 1]; ++k) {
    if (!query.meets(f.box[k])) continue;
    if (out.item.size() % kRun == 0) out.run.push_back(Aabb());
    out.item.push_back(k), out.box.push_back(f.box[k]);
    out.run.back().include(f.box[k]);
  }
}

std::span<const std::uint32_t> FlatParts::hits(const Some& a, std::size_t k, const Some& b, std::size_t from,
                                               const Vec3& apart) {
  const BoxQuery query(swept(a.box[k], -apart));  // the other block stands still
  if (hits_.size() < b.item.size()) hits_.resize(b.item.size());
  std::size_t n = 0;
  for (std::size_t r = from / kRun; r < b.run.size(); ++r) {
    if (!query.meets(b.run[r])) continue;
    for (std::size_t i = std::max(r * kRun, from), end = std::min((r + 1) * kRun, b.item.size()); i < end; ++i) {
      hits_[n] = b.item[i];
      n += query.meets(b.box[i]) ? 1 : 0;
    }
  }
  return {hits_.data(), n};
}

}  // namespace feder
