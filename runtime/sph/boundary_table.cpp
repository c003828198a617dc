// Integrals of boundary terms as sums over rings (3D) or pairs (2D) at height z above the particle: dV = 2 pi q dq dz
// or 2 dq dz, u^2 = z^2 + q^2. For friction the offset along the boundary counts: q^2/2 on average over a ring, q^2 in
// 2D. Made once per fluid.
#include "sph/boundary_table.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace feder {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kRings = 400;

// Sums over one layer at height z, per unit of height.
struct Layer {
  double colour = 0, friction = 0;
};

Layer layer(const Kernel& k, int d, double z) {
  Layer sum;
  const double radius = std::sqrt(std::max(0.0, 1 - z * z)), dq = radius / kRings;
  for (int i = 0; i < kRings; ++i) {
    const double q = (i + 0.5) * dq, u = std::sqrt(z * z + q * q);
    const double dv = d == 3 ? 2 * kPi * q * dq : 2 * dq;
    sum.colour += dv * k.gradient.value(d, u);
    if (k.radial_viscosity) {
      const double along = d == 3 ? q * q / 2 : q * q;
      sum.friction -= dv * 2 * (d + 2) * k.viscosity.slope(d, u) * along / (u * u) * z;
    } else {
      sum.friction += dv * k.viscosity.laplacian(d, u) * z;
    }
  }
  return sum;
}

// Viscous sum for v_x = y^2, whose Laplacian is 2: the term of a neighbour that slides by, averaged over its positions.
double row_viscosity(const Kernel& k, int d, double support, int x, int y, int z) {
  constexpr int kPlaces = 8;
  double sum = 0;
  for (int i = 0; i < kPlaces; ++i) {
    const double along = x + static_cast<double>(i) / kPlaces, r2 = along * along + y * y + z * z;
    const double u = std::sqrt(r2) / support;
    if (u >= 1) continue;
    const double unit = 1 / std::pow(support, d + 2);
    sum += k.radial_viscosity ? -(d + 2) * unit * k.viscosity.slope(d, u) * along * along * y * y / r2
                              : unit * k.viscosity.laplacian(d, u) * y * y / 2;
  }
  return sum / kPlaces;
}

}  // namespace

LatticeSums lattice_sums(const Kernel& k, int d, double support) {
  LatticeSums s;
  const int n = static_cast<int>(support) + 1;
  const double scale = 1 / std::pow(support, d);
  for (int x = -n; x <= n; ++x)
    for (int y = -n; y <= n; ++y)
      for (int z = d == 3 ? -n : 0; z <= (d == 3 ? n : 0); ++z) {
        const double u = std::sqrt(static_cast<double>(x * x + y * y + z * z)) / support;
        s.whole += scale * k.density.value(d, u);
        const double slope = scale * k.gradient.slope(d, u) * u / support;
        if (u > 0) s.squares += slope * slope;
        if (y != 0) s.viscosity += row_viscosity(k, d, support, x, y, z);
        if (y >= 0) continue;
        s.missing += scale * k.density.value(d, u);
        s.missing_slope += scale * k.gradient.slope(d, u) * -y / (support * support);
      }
  s.viscosity /= s.whole;
  return s;
}

double cohesion_moment(int power) {
  constexpr int kCuts = 4000;
  double sum = 0;
  for (int i = 0; i < kCuts; ++i) {
    const double u = (i + 0.5) / kCuts, a = u * (1 - u), a3 = 64 * a * a * a;
    sum += std::pow(u, power) * (u < 0.5 ? a3 + std::min(a3 - 1, 0.0) : a3) / kCuts;
  }
  return sum;
}

ColorSums color_sums(int d, double support) {
  ColorSums sums;
  const int n = static_cast<int>(support) + 1;
  std::vector<double> layer(static_cast<std::size_t>(n) + 1, 0);  // at a height of so many spacings, either way
  for (int x = -n; x <= n; ++x)
    for (int z = d == 3 ? -n : 0; z <= (d == 3 ? n : 0); ++z)
      for (int y = 0; y <= n; ++y)
        layer[static_cast<std::size_t>(y)] += std::max(0.0, 1 - (x * x + y * y + z * z) / (support * support));
  for (int y = 0; y <= n; ++y) sums.whole += (y == 0 ? 1 : 2) * layer[static_cast<std::size_t>(y)];
  double lacks = 0;
  for (int y = n; y > 0; --y) {  // the layer that many below the face lacks all layers from that height on
    lacks += layer[static_cast<std::size_t>(y)] / sums.whole;
    sums.lack += lacks * lacks * lacks;
    const double s = (y - 0.5) / support;
    if (s < 1) sums.depth += (1 - s * s) * (1 - s * s);
  }
  return sums;
}

ColorShare color_beyond(int d, WideReal s) {
  s = std::clamp(s, WideReal(0), WideReal(1));
  const WideReal a = 1 - s * s;
  if (d == 3) return {(8 - s * (15 - s * s * (10 - 3 * s * s))) / 16, WideReal(-15.0 / 16) * a * a};
  const WideReal root = std::sqrt(a), pi = static_cast<WideReal>(kPi);
  return {std::max(WideReal(0), WideReal(0.5) - (s * root * (5 - 2 * s * s) / 3 + std::asin(s)) / pi),
          -8 / (3 * pi) * a * root};
}

BoundaryTable::BoundaryTable(const Kernel& kernel, int d, double support) {
  const LatticeSums l = lattice_sums(kernel, d, support);
  const double first = 0.5 / support, value = l.missing / l.whole;
  const double steep = -2 * l.missing_slope * support / l.missing;  // per support
  // shifted to 0 at the support, which changes the first layer by less than the table's rounding
  const double end = std::exp(-steep * (1 - first));
  // cells from the far side down
  double friction = 0, share = 0;
  constexpr int kFine = 8;
  for (int i = kCells; i >= 0; --i) {
    const double s = 2.0 * i / kCells - 1;
    const double at = std::exp(-steep * (std::max(s, 0.0) - first));
    BoundaryTerms& out = samples_[i];
    out.value = static_cast<WideReal>(value * std::max(0.0, (at - end) + steep * at * std::max(0.0, -s)));
    out.slope = static_cast<WideReal>(i == kCells ? 0 : value * steep * at);
    out.colour = static_cast<WideReal>(layer(kernel, d, s).colour);
    out.friction = static_cast<WideReal>(friction);
    out.share = static_cast<WideReal>(share);
    // midpoint rule: the half space beyond s consists of the layers higher than s
    const double dz = 2.0 / kCells / kFine;
    for (int k = 0; k < kFine && i > 0; ++k) {
      const Layer slice = layer(kernel, d, s - (k + 0.5) * dz);
      share += dz * slice.colour;
      if (s > 0) friction += dz * slice.friction;
    }
  }
  // shares by colour: both fall with the distance, colour from its value at the plane to 0
  const WideReal full = samples_[kCells / 2].colour;
  int at = kCells;
  for (int i = 0; i <= kAirCells; ++i) {
    const WideReal wanted = full * static_cast<WideReal>(i) / kAirCells;
    while (at > kCells / 2 && samples_[at - 1].colour <= wanted) --at;
    const BoundaryTerms& far = samples_[at];
    const BoundaryTerms& near = samples_[std::max(at - 1, kCells / 2)];
    const WideReal between = near.colour > far.colour ? (wanted - far.colour) / (near.colour - far.colour) : 0;
    air_[i] = far.share + std::min(std::max(between, WideReal(0)), WideReal(1)) * (near.share - far.share);
  }
}

}  // namespace feder
