// Greedy colouring of elements: a colour holds elements that share no vertex, so its lanes and batches may run in any
// order and on any thread, with the same bits (Fratarcangeli and Pellacini 2015 colour constraints likewise). At a
// vertex of more than 64 elements of a kind the rest get colours of their own behind the last one, of one lane each.
// Kept between calls: colours and batches of the mesh, by its version. Weak spot: the order of sweeps, and with it the
// strain that a sweep leaves, follows from the numbering of the mesh.
#include "cloth/batches.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/jobs.h"
#include "base/wide.h"
#include "cloth/dihedral.h"
#include "cloth/long_links.h"

namespace feder {
namespace {
constexpr JobGrain kBatchGrain{32, 3'000};  // batches per job
constexpr JobGrain kBaseGrain{64, 4'000};   // likewise, where they only read positions
constexpr std::uint32_t kColors = 64;
// of the strain at which ties act, at which long links do: links between their ends stretch beyond
constexpr Real kLongShare = Real(0.85);

std::uint32_t direction(const ClothLink& l) { return l.b - l.a; }
std::uint32_t direction(const LongLink& l) { return l.b - l.a; }
std::uint32_t direction(const ClothHinge& h) { return h.v[1] > h.v[0] ? h.v[1] - h.v[0] : h.v[0] - h.v[1]; }
}  // namespace

double hinge_response(const ClothView& v, const std::uint32_t (&at)[4]) {
  const Vec3 e = v.rest[at[1]] - v.rest[at[0]], a = v.rest[at[2]] - v.rest[at[0]], b = v.rest[at[3]] - v.rest[at[0]],
             n1 = cross(e, a), n2 = cross(b, e);
  if (!(dot(n1, n1) > 0 && dot(n2, n2) > 0 && dot(e, e) > 0)) return 0;
  const Dihedral<Vec3> d = dihedral(e, a, b, HingeFloor());
  double response = 0;
  for (int i = 0; i < 4; ++i)
    if (v.mass[at[i]] > 0) response += static_cast<double>(dot(d.gradient[i], d.gradient[i]) / v.mass[at[i]]);
  return response;
}

double stiffest_link(const ClothView& v) {
  std::vector<double> sum(v.points, 0);
  for (const ClothLink& l : v.mesh->links) sum[l.a] += double(l.stiffness), sum[l.b] += double(l.stiffness);
  double most = 0;
  for (std::uint32_t i = 0; i < v.points; ++i)
    if (v.mass[i] > 0) most = std::fmax(most, sum[i] / double(v.mass[i]));
  return most;
}

double stiffest_hinge(const ClothView& v) {
  double most = 0;
  for (const ClothHinge& k : v.mesh->hinges) most = std::fmax(most, hinge_response(v, k.v) * double(k.stiffness));
  return most;
}

void ClothBatches::pick([[maybe_unused]] bool wide) {
#if defined(__x86_64__) || defined(__i386__)
  if (wide && runs_avx2()) kernels_ = &kClothKernelsAvx2;
#endif
}

template <class Elements, class Points>
std::uint32_t ClothBatches::color(const Elements& elements, std::uint32_t total, Points&& points) {
  used_.assign(total, 0);
  color_.resize(elements.size());
  // sorted by direction: the rows of a sheet then alternate between two colours, which leaves the least strain
  order_.resize(elements.size());
  for (std::uint32_t e = 0; e < order_.size(); ++e) order_[e] = e;
  std::stable_sort(order_.begin(), order_.end(),
                   [&](std::uint32_t x, std::uint32_t y) { return direction(elements[x]) < direction(elements[y]); });
  // the lowest colour that no vertex of the element has yet
  std::uint32_t count = 0, alone = 0;
  for (const std::uint32_t e : order_) {
    std::uint64_t taken = 0;
    points(elements[e], [&](std::uint32_t v) {
      FEDER_ASSERT(v + 1 < total);  // the last is the spare
      taken |= used_[v];
    });
    if (taken == ~std::uint64_t(0)) {
      color_[e] = kColors + alone++;
      continue;
    }
    const auto free = static_cast<std::uint32_t>(__builtin_ctzll(~taken));
    points(elements[e], [&](std::uint32_t v) { used_[v] |= std::uint64_t(1) << free; });
    color_[e] = free;
    count = std::max(count, free + 1);
  }
  // elements without a free colour follow the last one, each as a colour
  for (std::uint32_t& c : color_)
    if (c >= kColors) c = count + (c - kColors);
  return count + alone;
}

void ClothBatches::build(const ClothView& v) {
  if (version_ == v.version) return;
  FEDER_ASSERT(v.mesh && v.total > v.points);
  version_ = v.version;
  const std::uint32_t spare = v.total - 1;
  // batches of one kind, colour after colour, in the order of the elements
  const auto fill = [&](auto& batches, auto& colors, std::uint32_t count, const auto& elements, auto&& empty,
                        auto&& put, auto& lanes) {
    batches.clear(), colors.clear(), lanes.clear();
    std::size_t placed = 0;
    for (std::uint32_t c = 0; c < count; ++c) {
      const auto first = static_cast<unsigned>(batches.size());
      int lane = kLanes;
      for (std::size_t e = 0; e < elements.size(); ++e) {
        if (color_[e] != c) continue;
        if (lane == kLanes) batches.push_back(empty), lane = 0;
        ++placed;
        if (v.flows) {
          lanes.resize(batches.size() * kLanes, kNone);
          lanes[(batches.size() - 1) * kLanes + static_cast<std::size_t>(lane)] = static_cast<std::uint32_t>(e);
        }
        put(batches.back(), lane++, elements[e]);
      }
      colors.push_back({first, static_cast<unsigned>(batches.size())});
    }
    FEDER_ASSERT(placed == elements.size());
  };
  const auto compliance = [](Real k) { return k > 0 ? 1 / k : Real(1e30); };

  // empty lanes: the spare vertex, and no division by zero
  LinkBatch no_link{};
  for (int i = 0; i < kLanes; ++i) no_link.a[i] = no_link.b[i] = spare, no_link.compliance.v[i] = 1;
  std::uint32_t count = color(v.mesh->links, v.total, [](const ClothLink& l, auto&& f) { f(l.a), f(l.b); });
  fill(
      links_, link_colors_, count, v.mesh->links, no_link,
      [&](LinkBatch& b, int i, const ClothLink& l) {
        b.a[i] = l.a, b.b[i] = l.b, b.rest.v[i] = l.rest, b.compliance.v[i] = compliance(l.stiffness);
      },
      link_lane_);

  HingeBatch no_hinge{};
  for (int i = 0; i < kLanes; ++i) {
    for (auto& row : no_hinge.v) row[i] = spare;
    no_hinge.cosine.v[i] = no_hinge.compliance.v[i] = 1;
  }
  count = color(v.mesh->hinges, v.total, [](const ClothHinge& h, auto&& f) {
    for (std::uint32_t k : h.v) f(k);
  });
  fill(
      hinges_, hinge_colors_, count, v.mesh->hinges, no_hinge,
      [&](HingeBatch& b, int i, const ClothHinge& h) {
        for (int k = 0; k < 4; ++k) b.v[k][i] = h.v[k];
        sin_cos(h.angle, b.sine.v[i], b.cosine.v[i]);
        b.compliance.v[i] = compliance(h.stiffness);
      },
      hinge_lane_);
  rests_ = v.rests;
  measure_hinges(v);
  if (quadratic_) quadratic_->build(v);
}

// Those that flow have no lengths that hold.
void ClothBatches::build_long(const ClothView& v) {
  if (long_version_ == v.version || v.flows || !(v.max_strain < kInfinity)) return;
  long_version_ = v.version;
  const std::vector<LongLink> all = long_links(*v.mesh, v.rest, v.points);
  const std::uint32_t count = color(all, v.total, [](const LongLink& l, auto&& f) { f(l.a), f(l.b); });
  LinkBatch empty{};
  for (int i = 0; i < kLanes; ++i) empty.a[i] = empty.b[i] = v.total - 1;
  long_links_.clear(), long_colors_.clear();
  for (std::uint32_t c = 0; c < count; ++c) {
    const auto first = static_cast<unsigned>(long_links_.size());
    int lane = kLanes;
    for (std::size_t e = 0; e < all.size(); ++e) {
      if (color_[e] != c) continue;
      if (lane == kLanes) long_links_.push_back(empty), lane = 0;
      LinkBatch& b = long_links_.back();
      b.a[lane] = all[e].a, b.b[lane] = all[e].b, b.rest.v[lane++] = all[e].rest;
    }
    long_colors_.push_back({first, static_cast<unsigned>(long_links_.size())});
  }
}

// Rest lengths and angles that have flowed.
void ClothBatches::take_rests(const ClothView& v) {
  if (rests_ == v.rests) return;
  rests_ = v.rests;
  FEDER_ASSERT(link_lane_.size() == links_.size() * kLanes && hinge_lane_.size() == hinges_.size() * kLanes);
  for (std::size_t n = 0; n < link_lane_.size(); ++n)
    if (link_lane_[n] != kNone) links_[n / kLanes].rest.v[n % kLanes] = v.mesh->links[link_lane_[n]].rest;
  for (std::size_t n = 0; n < hinge_lane_.size(); ++n)
    if (hinge_lane_[n] != kNone) {
      HingeBatch& b = hinges_[n / kLanes];
      sin_cos(v.mesh->hinges[hinge_lane_[n]].angle, b.sine.v[n % kLanes], b.cosine.v[n % kLanes]);
    }
}

void ClothBatches::current_position(const ClothView& v, JobPool& jobs) {
  if (v.flows) take_rests(v);
  const auto put = [](Lane8x3& to, int i, const Vec3& d) { to.x.v[i] = d[0], to.y.v[i] = d[1], to.z.v[i] = d[2]; };
  const auto links = [&](Array<LinkBatch>& batches) {
    jobs.for_blocks(static_cast<std::uint32_t>(batches.size()), kBaseGrain,
                    [&](std::uint32_t first, std::uint32_t last, int) {
                      for (std::uint32_t n = first; n < last; ++n) {
                        LinkBatch& b = batches[n];
                        for (int i = 0; i < kLanes; ++i) put(b.base, i, v.position[b.b[i]] - v.position[b.a[i]]);
                      }
                    });
  };
  links(links_);
  if (long_version_ == v.version) links(long_links_);
  jobs.for_blocks(
      static_cast<std::uint32_t>(hinges_.size()), kBaseGrain, [&](std::uint32_t first, std::uint32_t last, int) {
        for (std::uint32_t n = first; n < last; ++n)
          for (int k = 0; k < 3; ++k)
            for (int i = 0; i < kLanes; ++i)
              put(hinges_[n].base[k], i, v.position[hinges_[n].v[k + 1][i]] - v.position[hinges_[n].v[0][i]]);
      });
  if (quadratic_) quadratic_->current_position(v, jobs);
}

void ClothBatches::limit(const ClothView& v, Real h, StepContext& c) {
  if (!(v.max_strain < kInfinity)) return;
  FEDER_ASSERT(v.max_strain > 0);
  ClothPass p = pass(v, h);
  p.stretched = 1 + v.max_strain;
  run(kernels_->limit_links, link_colors_, p, c);
}

void ClothBatches::reach(const ClothView& v, Real h, StepContext& c) {
  if (!(v.max_strain < kInfinity) || long_version_ != v.version || long_links_.empty()) return;
  ClothPass p = pass(v, h);
  p.links = long_links_.data();
  p.stretched = 1 + kLongShare * (v.tie_limit - 1);
  run(kernels_->limit_links, long_colors_, p, c);
}

void ClothBatches::tie(const ClothView& v, Real h, StepContext& c) {
  ClothPass p = pass(v, h);
  p.ties = v.ties.data();
  std::uint32_t first = 0;
  for (const std::uint32_t last : v.tie_layers) {
    FEDER_ASSERT(first <= last && last <= v.ties.size());
    c.jobs->for_blocks(last - first, kBatchGrain, [&](std::uint32_t a, std::uint32_t b, int) {
      ClothPass part = p;
      part.first = first + a, part.last = first + b;
      kernels_->ties(part);
    });
    first = last;
  }
}

ClothPass ClothBatches::pass(const ClothView& v, Real h) {
  FEDER_ASSERT(version_ == v.version);  // batches of another mesh name other vertices
  FEDER_ASSERT(h > 0);
  ClothPass p{};
  p.links = links_.data(), p.hinges = hinges_.data();
  p.delta_position = &v.delta_position->x, p.before = &v.before->x, p.velocity = &v.velocity->x;
  p.h = h;
  return p;
}

void ClothBatches::run(Kernel kernel, const Array<Color>& colors, ClothPass pass, StepContext& c) {
  for_colors(colors, kBatchGrain, stages_, *c.jobs, [&](std::uint32_t first, std::uint32_t last, int) {
    ClothPass part = pass;
    part.first = first, part.last = last;
    kernel(part);
  });
}

void ClothBatches::solve(const ClothView& v, Real h, bool hinges, Sweep sweep, StepContext& c) {
  ClothPass pass = this->pass(v, h);
  pass.inv_h2 = 1 / (h * h), pass.again = sweep.index > 0, pass.once = sweep.count == 1;
  pass.stretched = 1 + v.max_strain;
  const bool limited = v.max_strain < kInfinity, taut = v.taut && !pass.again;
  run(limited ? (taut ? kernels_->limited_taut_links : kernels_->limited_links)
              : (taut ? kernels_->taut_links : kernels_->links),
      link_colors_, pass, c);
  if (hinges) run(kernels_->hinges, hinge_colors_, pass, c);
}

void ClothBatches::bend(const ClothView& v, Real h, StepContext& c) {
  ClothPass p = pass(v, h);
  if (!quadratic_ || !quadratic_->exists()) return run(kernels_->bend_hinges, hinge_colors_, p, c);
  quadratic_->write(p);
  c.jobs->for_blocks(quadratic_->blocks(), kBatchGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    ClothPass part = p;
    part.first = first, part.last = last;
    kernels_->bend_flat(part);
  });
}

}  // namespace feder
