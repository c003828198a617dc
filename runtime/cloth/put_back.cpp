// Vertices that a script put far away. Elastic energy grows with the square of the distance: at 100 edge lengths it
// would throw a sheet apart for seconds. What lies more than kFar edge lengths from the mean of its neighbours is put
// there before the step, with a warning, the farthest first; at most kMost in a step, as cloth of which all vertices
// were put somewhere has no place to go back to. Pins stay and count for nothing: a script may carry them away. Cloth
// that may tear does that instead.
#include <cmath>

#include "cloth/impl.h"
#include "feder/params.h"

namespace feder {
namespace {
constexpr Real kFar = 4;  // mean rest lengths of its edges
constexpr std::uint32_t kMost = 16;
}  // namespace

std::uint32_t Cloth::Impl::farthest(const Sheet& s, Real& distance, Vec3& mean) {
  const Vec3* x = vertices.position.data() + s.first;
  const Vec3* rest = vertices.rest.data() + s.first;
  const Real* inv_mass = vertices.inv_mass.data() + s.first;
  neighborhoods.assign(s.points, {});
  const auto add = [&](std::uint32_t to, std::uint32_t of, Real size) {
    if (inv_mass[of] == 0) return;
    Neighborhood& n = neighborhoods[to];
    n.sum += x[of], n.rest += size, ++n.count;
  };
  for (const ClothEdge& e : s.mesh.edges) {
    if (e.a >= s.points || e.b >= s.points) continue;  // hidden ones, of clamped borders
    const Real size = length(rest[e.b] - rest[e.a]);
    add(e.a, e.b, size), add(e.b, e.a, size);
  }
  std::uint32_t found = kNone;
  distance = kFar;
  for (std::uint32_t i = 0; i < s.points; ++i) {
    const Neighborhood& n = neighborhoods[i];
    if (inv_mass[i] == 0 || n.count == 0 || !(n.rest > 0)) continue;
    const auto count = static_cast<Real>(n.count);
    const Vec3 middle = n.sum / count;
    const Real lengths = length(x[i] - middle) * count / n.rest;
    if (lengths > distance) found = i, distance = lengths, mean = middle;
  }
  return found;
}

void Cloth::Impl::put_back(Sheet& s, StepContext& c) {
  if (!s.state.edited || s.state.suspect_steps != Sheet::kSuspectSteps || s.settings.tear_strain < kInfinity) return;
  Real lengths = 0, most = 0;
  std::uint32_t first = kNone, count = 0;
  for (; count < kMost; ++count) {
    Vec3 mean = Vec3::Zero();
    const std::uint32_t i = farthest(s, lengths, mean);
    if (i == kNone) break;
    if (count == 0) first = i, most = lengths;
    vertices.position[s.first + i] = mean;
  }
  if (count == 0) return;
  c.events->warn("overstretched",
                 objects.describe(s.object) + ": vertex " + std::to_string(first + 1) + " was put " +
                     print_number(std::round(double(most))) + " edge lengths from its neighbours and is put back " +
                     "between them" + (count > 1 ? ", and " + std::to_string(count - 1) + " more likewise" : "") +
                     ": move vertices by less than " + print_number(double(kFar)) +
                     " edge lengths a step, pin them, or let the cloth tear (tear_strain)",
                 s.object);
}

}  // namespace feder
