// The arithmetic of flat_batch.h. Included by flat_kernel_plain.cpp and flat_kernel_avx2.cpp, which differ in compiler
// flags only and give the same bits.
#pragma once
#include "contact/flat_batch.h"

namespace feder {
namespace {

using namespace lanes;

void flat_gradients(FlatPass& p) {
  Lanes3 sum[2] = {{zero_lanes(), zero_lanes(), zero_lanes()}, {zero_lanes(), zero_lanes(), zero_lanes()}};
  for (unsigned k = 0; k < p.count; ++k) {
    const FlatBatch& b = p.batches[k];
    const Lanes inverse[4] = {load(b.inverse[0]), load(b.inverse[1]), load(b.inverse[2]), load(b.inverse[3])};
    const auto put = [&](const WideReal* rows, Lanes3(&f)[2]) {
      const Lanes3 base = load_points(rows, b.v[0]);
      const Lanes3 a = load_points(rows, b.v[1]) - base, c = load_points(rows, b.v[2]) - base;
      f[0] = a * inverse[0] + c * inverse[2], f[1] = a * inverse[1] + c * inverse[3];
    };
    Lanes3 start[2], change[2];
    put(p.at, start), put(p.way, change);
    for (int n = 0; n < 2; ++n) {
      store(p.gradients[k].start[n], start[n]), store(p.gradients[k].change[n], change[n]);
      sum[n] = sum[n] + (start[n] + change[n] * all_lanes(0.5f)) * load(b.area);
    }
  }
  for (int n = 0; n < 2; ++n) {
    Lane8x3 all;
    store(all, sum[n]);
    for (WideReal& x : p.sum[n]) x = 0;
    for (int i = 0; i < kLanes; ++i) p.sum[n][0] += all.x.v[i], p.sum[n][1] += all.y.v[i], p.sum[n][2] += all.z.v[i];
  }
}

void flat_test(FlatPass& p) {
  Lanes3 e[2];
  for (int n = 0; n < 2; ++n) e[n] = {all_lanes(p.frame[n][0]), all_lanes(p.frame[n][1]), all_lanes(p.frame[n][2])};
  Lanes least = all_lanes(2), largest = zero_lanes();
  const auto test = [&](const Lanes3& f0, const Lanes3& f1) {
    const Lanes xx = dot(e[0], f0), yy = dot(e[1], f1), xy = (dot(e[0], f1) + dot(e[1], f0)) * all_lanes(0.5f);
    const Lanes half = (xx - yy) * all_lanes(0.5f);
    least = min((xx + yy) * all_lanes(0.5f) - square_root(half * half + xy * xy), least);
    largest = max(dot(f0, f0) + dot(f1, f1), largest);
  };
  for (unsigned k = 0; k < p.count; ++k) {
    const FlatGradients& g = p.gradients[k];
    const Lanes3 f0 = load(g.start[0]), f1 = load(g.start[1]);
    test(f0, f1);
    test(f0 + load(g.change[0]), f1 + load(g.change[1]));
  }
  Lane8 low, high;
  store(low, least), store(high, largest);
  p.least = low.v[0], p.largest = high.v[0];
  for (int i = 1; i < kLanes; ++i) {
    if (low.v[i] < p.least) p.least = low.v[i];
    if (high.v[i] > p.largest) p.largest = high.v[i];
  }
}

constexpr FlatKernels kFlatKernels = {flat_gradients, flat_test};

}  // namespace
}  // namespace feder
