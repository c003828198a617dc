// Images of particles behind solids (fluid/images.h), eight at a time. Included by files compiled twice: no std, no
// Eigen.
#pragma once
#include "sph/pairs.h"

namespace feder {
namespace {

template <class Density, class Gradient>
struct ImagesOf {
  struct Vector {
    WideReal x = 0, y = 0, z = 0;
  };
  [[gnu::always_inline]] static WideReal dot(const WideReal* a, const WideReal* b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  }
  [[gnu::always_inline]] static bool meet_in_corner(const ImageInput& in, const WideReal* a, const WideReal* b) {
    const WideReal cosine = dot(a, b);
    return cosine <= in.corner && -cosine <= in.corner;
  }

  // What one particle collects over its images.
  struct Sum {
    Lanes value = zero_lanes(), square = value, x = value, y = value, z = value;
    Vector own;  // of its own images, by the other of their ends
  };

  // Up to eight particles that may see images of particle i. The first of all is i itself.
  struct Eight {
    unsigned at[kLanes];
    unsigned count = 0;
  };

  // The faces of the eight at the solid of `face`; far where they have none.
  [[gnu::always_inline]] static Four faces_at(const ImageInput& in, const Eight& e, unsigned face) {
    const unsigned shape = in.shapes[face];
    unsigned found[kLanes];
    for (unsigned l = 0; l < kLanes; ++l) {
      found[l] = in.far_face;
      if (l >= e.count) continue;
      for (unsigned c = in.first[e.at[l]], end = in.first[e.at[l] + 1]; c < end; ++c)
        if (in.shapes[c] == shape) {
          found[l] = c;
          break;
        }
    }
    return gather(in.faces, found);
  }

  struct Seen {
    Lanes slope, value;
    LaneMask hit;
  };
  // Images at the squared distances q behind faces b of the eight, of particles on the side of face a, which count
  // `share`.
  [[gnu::always_inline]] static Seen see(const SweepInput& s, Lanes q, LaneMask side, Lanes share) {
    const Lanes u2 = q * all_lanes(s.inv_support * s.inv_support);
    const LaneMask hit = side & (u2 < all_lanes(WideReal(0.9999)));
    const Lanes u = min(square_root(u2), all_lanes(1));
    return {select(hit, Gradient::slope(u) * share, zero_lanes()), select(hit, Density::value(u) * share, zero_lanes()),
            hit};
  }
  [[gnu::always_inline]] static Lanes shares_of(const ImageInput& in, const Eight& e) {
    if (!in.shares) return all_lanes(1);
    Lanes share;
    for (unsigned l = 0; l < kLanes; ++l) share[l] = in.shares[e.at[l]];
    return share;
  }
  [[gnu::always_inline]] static LaneMask same_side(const ImageInput& in, const WideReal* a, const Four& b) {
    return all_lanes(a[0]) * b.x + all_lanes(a[1]) * b.y + all_lanes(a[2]) * b.z > all_lanes(in.opposite);
  }

  // What a motion of the solid at `face` does to the density of i by images of these slopes: each image moves by twice
  // the motion along the normal at i, weighed with the distance of the other, and along that at the other, weighed with
  // the distance of i. The latter has its moment about i.
  [[gnu::always_inline]] static void push(const ImageInput& in, unsigned face, const Four& theirs, Lanes slope,
                                          const Pair& p) {
    const WideReal* a = in.faces + 4ul * face;
    WideReal* out = in.pushes + ImageInput::kPush * static_cast<unsigned long>(face);
    const WideReal at_own = 2 * total(slope * theirs.w), twice = 2 * a[3];
    const Lanes x = slope * theirs.x, y = slope * theirs.y, z = slope * theirs.z;
    out[0] += at_own * a[0] + twice * total(x), out[1] += at_own * a[1] + twice * total(y),
        out[2] += at_own * a[2] + twice * total(z);
    if (!in.moments) return;
    out[3] += twice * total(p.y * z - p.z * y), out[4] += twice * total(p.z * x - p.x * z),
        out[5] += twice * total(p.x * y - p.y * x);
  }

  [[gnu::always_inline]] static void put(const ImageInput& in, unsigned i, unsigned n, Vector back, Vector there,
                                         unsigned other) {
    const unsigned block = in.block_first[i] + n / kLanes, lane = n % kLanes;
    ImageBlock &b = in.back[block], &t = in.there[block];
    b.gradient.x.v[lane] = back.x, b.gradient.y.v[lane] = back.y, b.gradient.z.v[lane] = back.z;
    t.gradient.x.v[lane] = there.x, t.gradient.y.v[lane] = there.y, t.gradient.z.v[lane] = there.z;
    b.other[lane] = t.other[lane] = other;
  }

  static void collect(const SweepInput& s, const ImageInput& in, unsigned i, const Eight& e, bool with_own, Sum& sum,
                      unsigned& next) {
    const Four other = gather(s.points, e.at);
    const Pair p = pair(spread(s.points + 4ul * i), other, all_lanes(s.inv_support));
    const Lanes r2 = p.x * p.x + p.y * p.y + p.z * p.z, two = all_lanes(2), share = shares_of(in, e);
    Sum3 back, there;
    LaneMask any_hit = {};
    const unsigned end = in.first[i + 1];
    for (unsigned c = in.first[i]; c < end; ++c) {
      const WideReal* a = in.faces + 4ul * c;
      if (a[3] >= in.support) continue;
      const Four aj = faces_at(in, e, c);
      const LaneMask side = same_side(in, a, aj);
      const Lanes q = r2 + all_lanes(4 * a[3]) * aj.w;
      const Seen one = see(s, q, side, share);
      if (!any(one.hit)) continue;
      any_hit |= one.hit;
      // offsets of the image that i sees from i, by both ends
      const Lanes mine = two * aj.w, twice = all_lanes(2 * a[3]);
      const Lanes ix = all_lanes(a[0]) * mine, iy = all_lanes(a[1]) * mine, iz = all_lanes(a[2]) * mine;
      const Lanes jx = twice * aj.x, jy = twice * aj.y, jz = twice * aj.z;
      sum.value += one.value;
      back.x += one.slope * (p.x + ix), back.y += one.slope * (p.y + iy), back.z += one.slope * (p.z + iz);
      there.x += one.slope * (jx - p.x), there.y += one.slope * (jy - p.y), there.z += one.slope * (jz - p.z);
      push(in, c, aj, one.slope, p);
      for (unsigned d = c + 1; d < end; ++d) {  // the image of the image
        const WideReal* b = in.faces + 4ul * d;
        if (!meet_in_corner(in, a, b)) continue;
        const Four bj = faces_at(in, e, d);
        const Lanes cosine = aj.x * bj.x + aj.y * bj.y + aj.z * bj.z, most = all_lanes(in.corner);
        const Seen two_of =
            see(s, q + all_lanes(4 * b[3]) * bj.w,
                one.hit & same_side(in, b, bj) & (cosine <= most) & (zero_lanes() - cosine <= most), share);
        if (!any(two_of.hit)) continue;
        const Lanes more = two * bj.w, twice_b = all_lanes(2 * b[3]), g = two_of.slope;
        sum.value += two_of.value;
        back.x += g * (p.x + ix + all_lanes(b[0]) * more), back.y += g * (p.y + iy + all_lanes(b[1]) * more),
            back.z += g * (p.z + iz + all_lanes(b[2]) * more);
        there.x += g * (jx + twice_b * bj.x - p.x), there.y += g * (jy + twice_b * bj.y - p.y),
            there.z += g * (jz + twice_b * bj.z - p.z);
        push(in, c, aj, g, p), push(in, d, bj, g, p);
      }
    }
    if (!any(any_hit)) return;
    sum.x += back.x, sum.y += back.y, sum.z += back.z;
    if (with_own) {
      sum.own = {there.x[0], there.y[0], there.z[0]};
      there.x[0] = there.y[0] = there.z[0] = 0;
    }
    sum.square += there.x * there.x + there.y * there.y + there.z * there.z;
    if (in.shares) {  // of the others by the position of i: images of i
      const Lanes own = all_lanes(in.shares[i]) / share;
      back.x *= own, back.y *= own, back.z *= own;
    }
    // only those seen are kept
    unsigned bits = bits_of(any_hit) & (with_own ? ~1u : ~0u);
    for (unsigned l = 0; l < kLanes; ++l) {
      if (!(bits >> l & 1)) continue;
      put(in, i, next++, {back.x[l], back.y[l], back.z[l]}, {there.x[l], there.y[l], there.z[l]}, e.at[l]);
    }
  }

  static void images(const SweepInput& s, const ImageInput& in, unsigned first, unsigned last) {
    const WideReal support2 = in.support * in.support;
    unsigned free = in.block_first[first];  // room for all of them begins there
    for (unsigned i = first; i < last; ++i) {
      in.block_first[i] = free;
      WideReal* pushes = in.pushes + ImageInput::kPush * static_cast<unsigned long>(in.first[i]);
      for (unsigned long k = 0; k < ImageInput::kPush * static_cast<unsigned long>(in.first[i + 1] - in.first[i]); ++k)
        pushes[k] = 0;
      in.sums[i] = ImageSum{};
      in.block_count[i] = 0;
      const WideReal nearest = in.nearest[i];
      if (nearest >= in.support) continue;
      Sum sum;
      unsigned next = 0;
      Eight e;
      e.at[e.count++] = i;
      bool with_own = true;
      const unsigned* row = s.neighbors + static_cast<unsigned long>(i) * s.stride;
      for (const unsigned* at = row; at != row + in.counts[i]; ++at) {
        e.at[e.count] = *at;
        e.count += 4 * nearest * in.nearest[*at] < support2;
        if (e.count < kLanes) continue;
        collect(s, in, i, e, with_own, sum, next);
        e.count = 0, with_own = false;
      }
      if (e.count > 0) {
        for (unsigned l = e.count; l < kLanes; ++l) e.at[l] = in.far_particle;
        collect(s, in, i, e, with_own, sum, next);
      }
      const unsigned blocks = (next + kLanes - 1) / kLanes;
      while (next < blocks * kLanes) put(in, i, next++, {}, {}, in.far_particle);
      in.block_count[i] = blocks;
      free += blocks;
      in.sums[i] = {{total(sum.x) + sum.own.x, total(sum.y) + sum.own.y, total(sum.z) + sum.own.z},
                    total(sum.value),
                    total(sum.square)};
    }
  }

  // Adds to the growth in `out` what images add, of the velocities s.velocity.
  static void growth(const SweepInput& s, const ImageInput& in, unsigned first, unsigned last, WideReal* out) {
    for (unsigned i = first; i < last; ++i) {
      if (in.block_count[i] == 0 && in.nearest[i] >= in.support) continue;
      const WideReal* v = s.velocity + 4ul * i;
      const ImageBlock* block = in.there + in.block_first[i];
      Lanes sum = zero_lanes();
      for (const ImageBlock* end = block + in.block_count[i]; block != end; ++block) {
        const Four u = gather(s.velocity, block->other);
        sum += load(block->gradient.x) * u.x + load(block->gradient.y) * u.y + load(block->gradient.z) * u.z;
      }
      out[i] += total(sum) + dot(in.sums[i].gradient, v);
    }
  }

  // Adds to the sums in `out4` what images add, of the weights in the points.
  static void push_by(const SweepInput& s, const ImageInput& in, unsigned first, unsigned last, WideReal* out4) {
    for (unsigned i = first; i < last; ++i) {
      if (in.block_count[i] == 0 && in.nearest[i] >= in.support) continue;
      const WideReal w = s.points[4ul * i + 3];
      const ImageBlock* block = in.back + in.block_first[i];
      Sum3 sum;
      for (const ImageBlock* end = block + in.block_count[i]; block != end; ++block) {
        const Lanes weight = gather(s.points, block->other).w;
        sum.x += weight * load(block->gradient.x), sum.y += weight * load(block->gradient.y),
            sum.z += weight * load(block->gradient.z);
      }
      const ImageSum& own = in.sums[i];
      out4[4ul * i] += total(sum.x) + w * own.gradient[0], out4[4ul * i + 1] += total(sum.y) + w * own.gradient[1],
          out4[4ul * i + 2] += total(sum.z) + w * own.gradient[2];
    }
  }
};

}  // namespace
}  // namespace feder
