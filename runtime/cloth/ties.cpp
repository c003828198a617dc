// Ties to the pins and attachments of a cloth, "long range attachments" (Kim, Chentanez and Mueller-Fischer 2012): the
// distance of a vertex from an anchor is limited to that along the cloth, times one and the largest strain. One sweep
// per solver substep carries a load across few links; a tie carries it at once, so a cloth that hangs from a pin does
// not stretch the links next to it. Anchors are pinned and attached vertices. Each vertex is tied to the two nearest
// pins (a sheet between two corners hangs from both) and to the nearest attached vertex, whose body takes the opposite
// impulse. Distances are geodesic on the rest shape: labels spread from anchors over triangles (Dijkstra), with the
// anchor unfolded into the plane of each (Novotni and Klein 2002), exact on a flat sheet; they pass round tears and
// holes. Ties to pins act in batches at the end of a solver's solver substep, those to attached vertices after the
// attachment rows. Where pins have been moved apart by more than the cloth allows, all ties to pins yield in
// proportion. Made anew when pins, attachments or the mesh change. Weak spot: cloth without pins or attachments has
// links only.
#include <algorithm>
#include <cmath>
#include <queue>
#include <tuple>

#include "cloth/impl.h"

namespace feder {
namespace {
constexpr std::size_t kNearest = 2;    // pins that a vertex is tied to
constexpr Real kTieShare = Real(0.8);  // of max_strain, at which ties to pins act: links next to a pin stretch beyond
constexpr std::size_t kFarPins = 32;   // sample by which pins are found to have moved apart

struct Label {
  std::uint32_t anchor = kNone;
  double distance = 0;  // m
};

// Geodesic distances from anchors: for each vertex those of the nearest few.
class Geodesic {
 public:
  Geodesic(const ClothMesh& mesh, std::span<const Vec3> rest, std::uint32_t points, std::size_t nearest)
      : mesh_(mesh), rest_(rest), nearest_(nearest), labels_(points * nearest), round_(points, [&](auto&& f) {
          for (std::uint32_t k = 0; k < mesh.triangles.size(); ++k) f(mesh.triangles[k], k / 3);
        }) {}

  void spread(std::span<const std::uint32_t> anchors) {
    FEDER_ASSERT(!anchors.empty() && queue_.empty());
    for (const std::uint32_t a : anchors) queue_.push({0, a, a});
    while (!queue_.empty()) {
      const auto [distance, vertex, anchor] = queue_.top();
      queue_.pop();
      Label* l = find(vertex, kNone);
      if (!l || find(vertex, anchor)) continue;
      *l = {anchor, distance};
      for (const std::uint32_t triangle : round_.of(vertex)) {
        const std::uint32_t* t = &mesh_.triangles[3 * triangle];
        const int at = t[0] == vertex ? 0 : t[1] == vertex ? 1 : 2;
        FEDER_ASSERT(t[at] == vertex);  // round_ lists the triangles of the vertex
        pass_on(*l, vertex, t[(at + 1) % 3], t[(at + 2) % 3]);
        pass_on(*l, vertex, t[(at + 2) % 3], t[(at + 1) % 3]);
      }
    }
  }

  std::span<const Label> of(std::uint32_t vertex) const { return {&labels_[vertex * nearest_], nearest_}; }

 private:
  // The label of that anchor (kNone: the first free one), or null.
  Label* find(std::uint32_t vertex, std::uint32_t anchor) {
    Label* first = &labels_[vertex * nearest_];
    Label* last = first + nearest_;
    Label* found = std::find_if(first, last, [&](const Label& l) { return l.anchor == anchor; });
    return found == last ? nullptr : found;
  }

  // A label passes from a to c, along the edge or across the triangle a, b, c.
  void pass_on(const Label& from, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (!find(c, kNone) || find(c, from.anchor)) return;
    const double ac = static_cast<double>(length(rest_[c] - rest_[a]));
    double best = from.distance + ac;
    if (const Label* other = find(b, from.anchor))
      best = std::fmin(best, across(from.distance, other->distance, a, b, c));
    queue_.push({best, c, from.anchor});
  }

  // Distance of c from the anchor unfolded into the plane of the triangle, beyond the edge a-b; infinite where the
  // straight line does not cross that edge.
  double across(double da, double db, std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    const Vec3d ab = (rest_[b] - rest_[a]).cast<double>(), ac = (rest_[c] - rest_[a]).cast<double>();
    const double base = std::sqrt(ab.dot(ab));
    const double cx = ab.dot(ac) / base, cy = std::sqrt(std::fmax(ac.dot(ac) - cx * cx, 0));
    const double sx = (da * da - db * db + base * base) / (2 * base), sy = std::sqrt(std::fmax(da * da - sx * sx, 0));
    const double cross = sy + cy > 0 ? sx + (cx - sx) * sy / (sy + cy) : sx;
    if (!(cross >= -1e-9 * base && cross <= (1 + 1e-9) * base)) return double(kInfinity);
    return std::sqrt((cx - sx) * (cx - sx) + (cy + sy) * (cy + sy));
  }

  using Entry = std::tuple<double, std::uint32_t, std::uint32_t>;  // distance, vertex, anchor
  const ClothMesh& mesh_;
  std::span<const Vec3> rest_;
  std::size_t nearest_;
  std::vector<Label> labels_;
  Incidence round_;  // triangles at each vertex
  std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> queue_;
};

// A sample of pins: each the farthest from those before (Gonzalez 1985).
void pick_far(std::span<const std::uint32_t> pins, std::span<const Vec3> rest, Array<std::uint32_t>& out) {
  std::vector<Real> away(pins.size(), kInfinity);
  std::size_t next = 0;
  while (out.size() < std::min(kFarPins, pins.size())) {
    out.push_back(pins[next]);
    for (std::size_t k = 0; k < pins.size(); ++k) away[k] = std::min(away[k], length(rest[pins[k]] - rest[pins[next]]));
    next = static_cast<std::size_t>(std::max_element(away.begin(), away.end()) - away.begin());
  }
}
}  // namespace

void Cloth::Impl::make_ties(Sheet& s) {
  ClothTies& t = s.ties;
  t.batches.clear(), t.anchor.clear(), t.rest.clear(), t.layers.clear(), t.to_body.clear(), t.pins.clear();
  const std::span<const Vec3> rest(vertices.rest.data() + s.first, s.points);
  // anchors: pins, and attached vertices that are not pinned
  std::vector<std::uint32_t> pins, held;
  for (std::uint32_t i = 0; i < s.points; ++i)
    if (vertices.inv_mass[s.first + i] == 0) pins.push_back(i);
  if (!pins.empty() && pins.size() < s.points) pick_far(pins, rest, t.pins);
  if (!(s.settings.max_strain < kInfinity)) return;
  for (const Attachment& a : attachments)
    if (a.vertex >= s.first && a.vertex < s.first + s.points && vertices.inv_mass[a.vertex] != 0)
      held.push_back(a.vertex - s.first);
  // ties to pins, the nearest of all vertices in a layer, then the second nearest
  if (pins.size() < s.points && !pins.empty()) {
    Geodesic distances(s.mesh, rest, s.points, kNearest);
    distances.spread(pins);
    for (std::size_t n = 0; n < kNearest; ++n) {
      int lane = kLanes;
      for (std::uint32_t i = 0; i < s.points; ++i) {
        const Label l = distances.of(i)[n];
        if (l.anchor == kNone || vertices.inv_mass[s.first + i] == 0) continue;
        if (lane == kLanes) {
          TieBatch empty{};
          for (unsigned& a : empty.a) a = s.total - 1;
          t.batches.push_back(empty), lane = 0;
          t.anchor.resize(t.batches.size() * kLanes, kNone), t.rest.resize(t.batches.size() * kLanes, 0);
        }
        t.batches.back().a[lane] = i;
        const std::size_t at = (t.batches.size() - 1) * kLanes + static_cast<std::size_t>(lane++);
        FEDER_ASSERT(t.anchor[at] == kNone && vertices.inv_mass[s.first + l.anchor] == 0);
        t.anchor[at] = l.anchor, t.rest[at] = static_cast<Real>(l.distance);
      }
      t.layers.push_back(static_cast<std::uint32_t>(t.batches.size()));
    }
    // attached vertices to the pin that the cloth, and with it the body, hangs from
    for (const std::uint32_t a : held)
      if (const Label l = distances.of(a)[0]; l.anchor != kNone)
        t.to_body.push_back({l.anchor, a, static_cast<Real>(l.distance), true});
  }
  // ties to the nearest attached vertex
  if (held.empty()) return;
  Geodesic distances(s.mesh, rest, s.points, 1);
  distances.spread(held);
  for (std::uint32_t i = 0; i < s.points; ++i)
    if (const Label l = distances.of(i)[0]; l.anchor != kNone && l.anchor != i && vertices.inv_mass[s.first + i] != 0)
      t.to_body.push_back({i, l.anchor, static_cast<Real>(l.distance), false});
}

// The largest distance between two pins of the sample, over that at rest.
Real Cloth::Impl::pins_apart(const Sheet& s) const {
  const Vec3 *x = vertices.position.data() + s.first, *rest = vertices.rest.data() + s.first;
  Real most = 0;
  for (std::size_t a = 0; a < s.ties.pins.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) {
      const std::uint32_t i = s.ties.pins[a], j = s.ties.pins[b];
      most = std::max(most, length(x[i] - x[j]) / length(rest[i] - rest[j]));
    }
  return most;
}

// Positions of anchors in this step, and lengths of ties.
void Cloth::Impl::place_ties(Sheet& s) {
  ClothTies& t = s.ties;
  const Vec3* x = vertices.position.data() + s.first;
  const Real longest = 1 + s.settings.max_strain;
  const Real separation = std::max(Real(1), pins_apart(s) / longest);  // over what the cloth allows
  FEDER_ASSERT(t.anchor.size() == t.batches.size() * kLanes && !s.paths_stale);
  // bodies on it push the cloth against its ties and do not know them: there the links hold first
  const Real limit = (1 + (1 - s.unladen() * (1 - kTieShare)) * s.settings.max_strain) * separation;
  t.limit = limit;
  for (std::size_t n = 0; n < t.batches.size(); ++n)
    for (int k = 0; k < kLanes; ++k) {
      const std::size_t at = n * kLanes + static_cast<std::size_t>(k);
      TieBatch& b = t.batches[n];
      const Vec3 base = t.anchor[at] == kNone ? Vec3(0, 0, 0) : Vec3(x[b.a[k]] - x[t.anchor[at]]);
      b.base.x.v[k] = base[0], b.base.y.v[k] = base[1], b.base.z.v[k] = base[2];
      b.limit.v[k] = t.rest[at] * limit;
    }
}

template <class F>
Double3 Cloth::Impl::momentum_of(const Sheet& s, F&& velocity_of) const {
  Double3 sum{0, 0, 0};  // kg m/s
  for (std::uint32_t i = s.first; i < s.first + s.points; ++i)
    sum = sum + double(vertices.mass[i]) * wide(velocity_of(i));
  return sum;
}

// A solver that goes to a minimum has to know what hangs from a vertex, or its light end would follow the links and
// leave the body behind. So for its solver substep an attached vertex has its share of the body's mass and momentum
// too; and the body gets the share of what the solver gave to it. The attachment corrects what that leaves.
void Cloth::Impl::carry_bodies(Sheet& s, const SurfaceGroup& g, ClothView& v) {
  hauled.clear();
  const SolverBodies* bodies = surfaces.solver_bodies;
  for (std::uint32_t n = 0; n < g.attachments.size(); ++n) {
    const SurfaceAttachment& a = g.attachments[n];
    if (a.solver_index == 0 || a.vertex < s.first || a.vertex >= s.first + s.points) continue;
    const Real inv_mass = bodies->mass[a.solver_index].inv_mass_axes.maxCoeff();
    if (!(inv_mass > 0) || delta_position[a.vertex].w == 0) continue;
    Real share = 0;
    for (const SurfaceAttachment& b : g.attachments) share += b.solver_index == a.solver_index ? Real(1) : Real(0);
    hauled.push_back({n, 1 / (inv_mass * share), Vec3::Zero()});
  }
  if (hauled.empty()) return;
  carried_momentum =
      momentum_of(s, [&](std::uint32_t i) { return Vec3(velocity[i].vec() + g.step * acceleration[i]); });
  carried_afloat = std::all_of(delta_position.begin() + s.first, delta_position.begin() + s.first + s.points,
                               [](const Row4& x) { return x.w != 0; });
  carried_mass.assign(vertices.mass.begin() + s.first, vertices.mass.begin() + s.first + s.total);
  for (Carried& k : hauled) {
    const SurfaceAttachment& a = g.attachments[k.attachment];
    const SolverBody& body = bodies->state[a.solver_index];
    const Real own = vertices.mass[a.vertex], all = own + k.mass;
    k.velocity = body.velocity + cross(body.angular_velocity, a.arm);
    // the solver adds h a, of which the body has its own
    const Vec3 kick = g.step * acceleration[a.vertex];
    velocity[a.vertex].set((own * (velocity[a.vertex].vec() + kick) + k.mass * k.velocity) / all - kick);
    delta_position[a.vertex].w = velocity[a.vertex].w = 1 / all;
    carried_mass[a.vertex - s.first] = all;
  }
  v.mass = carried_mass.data();
}

// Before bodies move by their velocities in this solver substep. The rounding of displacements times the masses of
// bodies is far from small beside a light sheet: where nothing else holds it, they share what it has lost.
void Cloth::Impl::hand_over(const Sheet& s, const SurfaceGroup& g) {
  if (hauled.empty()) return;
  const auto moved = [&](std::uint32_t i) { return Vec3((delta_position[i].vec() - before[i].vec()) / g.step); };
  const auto given = [&](const Carried& k) {
    return Vec3(k.mass * (moved(g.attachments[k.attachment].vertex) - k.velocity));
  };
  Double3 owed = carried_momentum - momentum_of(s, moved);
  double all = 0;
  for (const Carried& k : hauled) owed = owed - wide(given(k)), all += double(k.mass);
  for (const Carried& k : hauled) {
    const SurfaceAttachment& a = g.attachments[k.attachment];
    Vec3 impulse = given(k);  // N s
    if (carried_afloat) impulse += narrow((double(k.mass) / all) * owed);
    SolverBody& body = surfaces.solver_bodies->state[a.solver_index];
    const SolverMass& mass = surfaces.solver_bodies->mass[a.solver_index];
    body.velocity += mass.inv_mass_axes.cwiseProduct(impulse);
    body.angular_velocity += mass.inv_inertia * cross(a.arm, impulse);
    delta_position[a.vertex].w = velocity[a.vertex].w = vertices.inv_mass[a.vertex];
  }
}

// Ties of vertices to the point of a body where the cloth is attached, and of that point to the pin it hangs from.
void Cloth::Impl::solve_body_ties(StepContext& c) {
  const SurfaceGroup& g = group(c);
  if (g.attachments.empty()) return;
  const Real h = g.step;
  const Array<SurfaceAttachment>& held = g.attachments;
  const SolverBodies* solver_bodies = surfaces.solver_bodies;
  for (const std::uint32_t member : g.members) {
    if (member >= sheets.size()) break;
    Sheet& s = *sheets[member];
    if (!s.active() || s.ties.to_body.empty()) continue;
    const Real longest = 1 + s.settings.max_strain;
    const SurfaceAttachment* attachment = nullptr;
    for (const ClothTies::ToBody& t : s.ties.to_body) {
      const std::uint32_t anchor = s.first + t.anchor, i = s.first + t.vertex;
      // the attachment of this anchor in the group
      if (!attachment || attachment->vertex != anchor) {
        const auto at =
            std::find_if(held.begin(), held.end(), [&](const SurfaceAttachment& k) { return k.vertex == anchor; });
        if (at == held.end()) continue;
        attachment = &*at;
      }
      FEDER_ASSERT(t.vertex < s.points && t.anchor < s.points);
      // excess of distance, and the response of both sides
      Row4& x = delta_position[i];
      const Vec3 point = vertices.position[anchor] - attachment->error +
                         surfaces.body_displacement(attachment->solver_index, attachment->arm);
      const Vec3 e = vertices.position[i] + x.vec() - point;
      const Real far = std::min(length(e) - t.rest * longest, t.rest * s.settings.max_strain);
      if (!(far > 0)) continue;
      const Vec3 n = normalized_or(e, Vec3(0, 1, 0));
      const Real response = x.w + surfaces.body_response(attachment->solver_index, attachment->arm, n);
      if (!(response > 0)) continue;
      // excess from before this solver substep is taken back at kTieSpeed
      Vec3 change = x.vec() - before[i].vec();
      if (before[i].w != 0) change += h * velocity[i].vec();
      if (attachment->solver_index != 0) {
        const SolverBody& m = solver_bodies->state[attachment->solver_index];
        change -= h * (m.velocity + cross(m.angular_velocity, attachment->arm));
      }
      const Real need = far - std::max(far - dot(n, change) - kTieSpeed * h, Real(0));
      if (!(need > 0)) continue;
      const Vec3 push = (need / response) * n;  // kg m
      x.add(-x.w * push);
      surfaces.push_body(attachment->solver_index, attachment->arm, push, h);
    }
  }
}

}  // namespace feder
