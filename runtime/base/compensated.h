// Compensated sums (Kahan 1965): a number as a rounded part and a low part of less than half its last place, so that
// increments far below that place add up instead of getting lost. Exact where |x| >= |d|; else the low part errs by a
// rounding of d. Needs arithmetic as written: -ffp-contract=off, no -ffast-math.
#pragma once
#include "feder/types.h"

namespace feder {

// x + low += d: three additions more than x += d.
inline void add_compensated(Real& x, Real& low, Real d) {
  const Real y = low + d, sum = x + y;
  low = y - (sum - x);
  x = sum;
}

inline void add_compensated(Vec3& x, Vec3& low, const Vec3& d) {
  for (int k = 0; k < 3; ++k) add_compensated(x[k], low[k], d[k]);
}

// The same for `count` numbers side by side, d = h v; written so that compilers make vectors of it.
template <int count>
inline void add_compensated(Real* __restrict x, Real* __restrict low, const Real* __restrict v, Real h) {
  Real y[count], sum[count];
  for (int k = 0; k < count; ++k) y[k] = low[k] + h * v[k];
  for (int k = 0; k < count; ++k) sum[k] = x[k] + y[k];
  for (int k = 0; k < count; ++k) low[k] = y[k] - (sum[k] - x[k]);
  for (int k = 0; k < count; ++k) x[k] = sum[k];
}

}  // namespace feder
