#include "fluid/images.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "fluid/pool.h"

namespace feder {
namespace {

constexpr Real kCorner = Real(0.7);     // cosine between two planes, up to which the image of an image counts
constexpr Real kOpposite = Real(-0.7);  // cosine between normals, up to which particles are on the same side of a solid
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
  Real reach(const BoundaryContact& k) const { return std::max(k.distance(p.x[k.particle].vec()), Real(0)); }
  // The contact of j with the solid of k, on the same side; null: none, and then no image is in reach.
  const BoundaryContact* at_same(const BoundaryContact& k, std::uint32_t j) const {
    for (const BoundaryContact& other : p.contacts_of(j))
      if (other.shape == k.shape) return dot(other.normal, k.normal) > kOpposite ? &other : nullptr;
    return nullptr;
  }
  // An image: of the particle of `kj` behind contact ki, or behind that and li; null: not.
  struct Image {
    const BoundaryContact *ki, *kj, *li, *lj;
    Real u2;
  };
  // f(image) for each in the kernel of i behind contact k; that of i is its own.
  template <class F>
  void each(std::uint32_t i, const BoundaryContact& k, F&& f) const {
    const Real s = reach(k);
    if (s * s * inv_r2 >= 1) return;
    const auto visit = [&](std::uint32_t j) {
      const BoundaryContact* kj = j == i ? &k : at_same(k, j);
      if (!kj) return;
      const Vec3 apart = p.x[i].vec() - p.x[j].vec();
      const Real u2 = (dot(apart, apart) + 4 * s * reach(*kj)) * inv_r2;
      if (u2 >= kNearlyOne) return;
      f(Image{&k, kj, nullptr, nullptr, u2});
      for (const BoundaryContact& l : p.contacts_of(i)) {
        if (&l <= &k || std::fabs(dot(l.normal, k.normal)) > kCorner) continue;
        const BoundaryContact* lj = j == i ? &l : at_same(l, j);
        if (!lj) continue;
        const Real v2 = u2 + 4 * reach(l) * reach(*lj) * inv_r2;
        if (v2 < kNearlyOne) f(Image{&k, kj, &l, lj, v2});
      }
    };
    visit(i);
    for (const std::uint32_t j : p.lists.row(i)) visit(j);
  }
  // Gradient of the term of an image by the position of the particle of `own`, over the slope.
  Vec3 by(const BoundaryContact& own, const BoundaryContact& other, const BoundaryContact* own2,
          const BoundaryContact* other2) const {
    Vec3 g = p.x[own.particle].vec() - p.x[other.particle].vec() + 2 * reach(other) * own.normal;
    if (own2) g += 2 * reach(*other2) * own2->normal;
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
        images.each(i, k, [&](const ImageGeometry::Image& m) { n += m.kj->particle != i; });
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
        images.each(i, k, [&](const ImageGeometry::Image& m) {
          const std::uint32_t j = m.kj->particle;
          const double u = std::sqrt(static_cast<double>(m.u2));
          const Real slope = images.slope_unit * static_cast<Real>(p.kernel->gradient.slope(p.dimension, u));
          sum.value += images.value_unit * static_cast<Real>(p.kernel->density.value(p.dimension, u));
          if (j == i) {
            sum.gradient += 2 * slope * images.by(*m.ki, *m.ki, m.li, m.li);  // both ends move
          } else {
            sum.gradient += slope * images.by(*m.ki, *m.kj, m.li, m.lj);
            const Vec3 g = slope * images.by(*m.kj, *m.ki, m.lj, m.li);
            sum.squares += dot(g, g);
            FEDER_ASSERT(at < first_[i + 1]);
            terms_[at++] = {g[0], g[1], g[2], j};
          }
          // the solids' motions
          const auto pushed = [&](const BoundaryContact& mi, const BoundaryContact& mj) {
            const Vec3 of_i = (2 * slope * images.reach(mj)) * mi.normal,
                       of_j = (2 * slope * images.reach(mi)) * mj.normal;
            const Vec3 center = boundary.body_of(mi).center;
            Push& push = pushes_[static_cast<std::size_t>(&mi - p.contacts.data())];
            push.linear += of_i + of_j;
            push.angular += cross(Vec3(p.x[i].vec() - center), of_i) + cross(Vec3(p.x[j].vec() - center), of_j);
          };
          pushed(*m.ki, *m.kj);
          if (m.li) pushed(*m.li, *m.lj);
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
