#include "fluid/images.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "fluid/pool.h"

namespace feder {
namespace {

constexpr Real kCorner = Real(0.7);  // cosine between two planes, up to which the image of an image counts
constexpr Real kOtherSide =
    Real(-0.25);  // spacings: a particle farther behind the plane is on the other side of a solid
constexpr Real kNearlyOne = Real(0.9999);  // of squared distances over the support's

// What the images of a pool are computed from.
struct ImageGeometry {
  const FluidPool& p;
  Real inv_r2, value_unit, slope_unit;

  explicit ImageGeometry(const FluidPool& pool) : p(pool) {
    inv_r2 = 1 / (p.support * p.support);
    value_unit = p.unit;
    for (int k = 0; k < p.dimension; ++k) value_unit /= p.support;
    slope_unit = value_unit * inv_r2;
  }
  Real reach(const BoundaryContact& k, std::uint32_t i) const { return std::max(k.distance(p.x[i].vec()), Real(0)); }
  bool beyond(const BoundaryContact& k, std::uint32_t j) const {
    return k.distance(p.x[j].vec()) < kOtherSide * p.desc.spacing;
  }
  // f(j, second contact or null, u^2) for each image in the kernel of i behind contact k; j == i is its own.
  template <class F>
  void each(std::uint32_t i, const BoundaryContact& k, F&& f) const {
    const Real s = reach(k, i);
    if (s * s * inv_r2 >= 1) return;
    const auto visit = [&](std::uint32_t j) {
      if (j != i && beyond(k, j)) return;
      const Vec3 apart = p.x[i].vec() - p.x[j].vec();
      const Real u2 = (dot(apart, apart) + 4 * s * reach(k, j)) * inv_r2;
      if (u2 >= kNearlyOne) return;
      f(j, static_cast<const BoundaryContact*>(nullptr), u2);
      for (const BoundaryContact& l : p.contacts_of(i)) {
        if (&l <= &k || std::fabs(dot(l.normal, k.normal)) > kCorner || (j != i && beyond(l, j))) continue;
        const Real v2 = u2 + 4 * reach(l, i) * reach(l, j) * inv_r2;
        if (v2 < kNearlyOne) f(j, &l, v2);
      }
    };
    visit(i);
    for (const std::uint32_t j : p.lists.row(i)) visit(j);
  }
  // Gradient by the position of i of the term of an image of j, over the slope.
  Vec3 by(std::uint32_t i, std::uint32_t j, const BoundaryContact& k, const BoundaryContact* l) const {
    Vec3 g = p.x[i].vec() - p.x[j].vec() + 2 * reach(k, j) * k.normal;
    if (l) g += 2 * reach(*l, j) * l->normal;
    return g;
  }
};

}  // namespace

void BoundaryImages::build(const FluidPool& p, const Boundary& boundary, JobPool& jobs) {
  const ImageGeometry images(p);
  const std::uint32_t contacts = p.contact_first[p.count];
  if (first_.size() <= p.count) first_.resize(p.contact_first.size()), back_first_.resize(p.contact_first.size());
  if (of_.size() < p.count) of_.resize(p.id.size());
  if (pushes_.size() < contacts) pushes_.resize(contacts + contacts / 4);

  // how many there are
  jobs.for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) {
      std::uint32_t n = 0;
      for (const BoundaryContact& k : p.contacts_of(i))
        images.each(i, k, [&](std::uint32_t j, const BoundaryContact*, Real) { n += j != i; });
      first_[i] = n, back_first_[i] = 0;
    }
  });
  std::exclusive_scan(first_.begin(), first_.begin() + p.count + 1, first_.begin(), 0u);
  const std::uint32_t total = first_[p.count];
  if (terms_.size() <= total) terms_.resize(total + total / 4 + 1), back_.resize(total + total / 4 + 1);

  jobs.for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) {
      Sum sum;
      std::uint32_t at = first_[i];
      for (std::uint32_t c = p.contact_first[i]; c < p.contact_first[i + 1]; ++c) pushes_[c] = Push{};
      for (std::uint32_t c = p.contact_first[i]; c < p.contact_first[i + 1]; ++c) {
        const BoundaryContact& k = p.contacts[c];
        images.each(i, k, [&](std::uint32_t j, const BoundaryContact* l, Real u2) {
          const double u = std::sqrt(static_cast<double>(u2));
          const Real slope = images.slope_unit * static_cast<Real>(p.kernel->gradient.slope(p.dimension, u));
          sum.value += images.value_unit * static_cast<Real>(p.kernel->density.value(p.dimension, u));
          if (j == i) {
            sum.gradient += 2 * slope * images.by(i, i, k, l);  // both ends move
          } else {
            sum.gradient += slope * images.by(i, j, k, l);
            const Vec3 g = slope * images.by(j, i, k, l);
            sum.squares += dot(g, g);
            FEDER_ASSERT(at < first_[i + 1]);
            terms_[at++] = {g[0], g[1], g[2], j};
          }
          // the solids' motions
          const auto pushed = [&](const BoundaryContact& m) {
            const Real si = images.reach(m, i), sj = images.reach(m, j);
            const Vec3 center = boundary.body_of(m).center;
            Push& push = pushes_[static_cast<std::size_t>(&m - p.contacts.data())];
            push.linear += 2 * slope * (si + sj) * m.normal;
            push.angular +=
                cross(Vec3(2 * slope * (sj * (p.x[i].vec() - center) + si * (p.x[j].vec() - center))), m.normal);
          };
          pushed(k);
          if (l) pushed(*l);
        });
      }
      FEDER_ASSERT(at == first_[i + 1]);
      of_[i] = sum;
    }
  });

  // the same terms by the other particle, in the order of the first
  for (std::uint32_t n = 0; n < total; ++n) ++back_first_[terms_[n].other];
  back_first_[p.count] = 0;
  std::inclusive_scan(back_first_.begin(), back_first_.begin() + p.count + 1, back_first_.begin());  // ends, for now
  for (std::uint32_t i = p.count; i-- > 0;)
    for (std::uint32_t n = first_[i + 1]; n-- > first_[i];) {
      Term& back = back_[--back_first_[terms_[n].other]];
      back = terms_[n];
      back.other = i;
    }
}

}  // namespace feder
