// The incremental potential of a chain's step (Kane, Marsden, Ortiz and West 2000; Radovitzky and Ortiz 1999): inertia,
// elastic energy, dissipation and contact with held friction limits, of which the forces are the negative gradient. The
// potential of Coulomb friction with a limit is Huber's: a parabola where it sticks, a line where it slips.
#include <cmath>

#include "rope/bend.h"
#include "rope/chain.h"

namespace feder {

double Chain::hinge_stiffness(const ChainStep& s, std::uint32_t middle) const {
  return 2 * s.bend / (double(s.rest_length[middle - 1]) + double(s.rest_length[middle]));
}

double Chain::clamp_stiffness(const ChainStep& s, bool last) const {
  return 2 * s.bend / double(s.rest_length[last ? s.count - 2 : 0]);
}

// At point i, of the points x; at a clamped end that to its direction.
double Chain::angle_at(const ChainStep& s, std::uint32_t i, const Array<Double3>& x) const {
  const auto direction = [&](std::uint32_t k) {
    const Double3 e = x[k + 1] - x[k];
    return direction_of(e, length(e));
  };
  if (i == 0) return s.clamped[0] ? bend_between(s.direction[0], direction(0)).angle : 0;
  if (i + 1 == s.count) return s.clamped[1] ? bend_between(s.direction[1], direction(i - 1)).angle : 0;
  return bend_between(direction(i - 1), direction(i)).angle;
}

void Chain::remember_bends(const ChainStep& s) {
  for (std::uint32_t i = 0; i < s.count; ++i) bent_[i] = angle_at(s, i, start);
}

double Chain::potential(const ChainStep& s, const Array<ChainContact>& contacts, const Array<ChainLoad>& loads,
                        const Array<Double3>& x) const {
  const double squared_rate = 1 / (s.h * s.h), damping = s.damping / s.h;
  double sum = 0;  // twice the potential
  for (std::uint32_t i = 0; i < s.count; ++i) {
    const Double3 d = x[i] - target[i];
    if (!held(s, i)) sum += s.mass[i] * squared_rate * dot(d, d);
  }
  for (const ChainLoad& l : loads) {
    const Double3 d = x[l.point] - start[l.point] - l.shift;
    sum += squared_rate * dot(d, times(l.mass, d));
  }
  for (std::uint32_t i = 0; i + 1 < s.count; ++i) {
    const double now = length(x[i + 1] - x[i]), rest = double(s.rest_length[i]);
    const double more = now - rest, change = now - length(start[i + 1] - start[i]);
    sum += s.stretch / rest * (more * more + damping * change * change);
  }
  for (std::uint32_t i = 0; wide_ && i < s.count; ++i) {
    const bool first = i == 0, last = i + 1 == s.count;
    if ((first && !s.clamped[0]) || (last && !s.clamped[1])) continue;
    const double angle = angle_at(s, i, x), change = angle - bent_[i];
    const double k = first || last ? clamp_stiffness(s, last) : hinge_stiffness(s, i);
    sum += k * (angle * angle + damping * change * change);
  }
  for (const ChainContact& c : contacts) {
    Press p;
    if (!press(s, c, x, p)) continue;
    sum += p.normal * p.normal / p.k[0];
    sum += (p.holding > p.most ? p.most * (2 * p.holding - p.most) : p.holding * p.holding) / p.k[1];
  }
  return sum / 2;
}

}  // namespace feder
