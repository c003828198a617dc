// Nets as surfaces (state/surface.h): points with a radius, and faces between them. A net is integrated once per
// substep; in the contact loop its points repeat that displacement at constant velocity, and the changes by contact are
// added to the net afterwards: a point without contact keeps its integrator's result to the bit.
// A net without faces shows its points as edges without length, which collide with edges as balls do.
// Weak spot: springs do not see what contact does within a substep; a stiff net with a long substep rings at a contact.
#include <algorithm>
#include <cmath>

#include "springs/impl.h"

namespace feder {
namespace {

constexpr int kMaxSteps = 16;               // solver substeps of a fast net
constexpr Real kTravelOfStep = Real(0.25);  // of the thickness: travel of a point in a solver substep

}  // namespace

void Net::list_edges() {
  edges.clear();
  for (std::size_t t = 0; t < faces.size(); t += 3)
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = faces[t + static_cast<std::size_t>(k)],
                          b = faces[t + static_cast<std::size_t>((k + 1) % 3)];
      edges.push_back({std::min(a, b), std::max(a, b)});
    }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  if (faces.empty())
    for (std::uint32_t i = 0; i < points; ++i) edges.push_back({i, i});
}

// Declares the number of nets that collide: contact has passes by that.
void Springs::Impl::declare_surfaces() {
  std::uint32_t count = 0;
  bool self = false, faces = false;
  for (const auto& n : nets) {
    if (!(particles.radius[n->first] > 0)) continue;
    ++count;
    self = self || n->settings.self != 0;
    faces = faces || !n->faces.empty();
  }
  if (Surfaces* surfaces = store.find<Surfaces>()) surfaces->declare({kName, count, false, self, faces});
}

void Springs::Impl::show_surfaces(StepContext& c) {
  Surfaces& all = store.get<Surfaces>();
  for (const auto& n : nets) {
    if (!(particles.radius[n->first] > 0)) continue;
    Surface s;
    s.object = n->object;
    s.first = all.claim(n->points), s.count = s.total = n->points;
    s.triangles = {n->faces.data(), n->faces.size()};
    s.edges = {n->edges.empty() ? nullptr : n->edges[0].data(), 2, static_cast<std::uint32_t>(n->edges.size())};
    s.rest = n->rest_position.data();
    s.thickness = 2 * particles.radius[n->first];
    s.friction = n->settings.friction;
    s.group = n->settings.group, s.mask = n->settings.mask;
    s.active = !n->frozen, s.coasts = s.balls = true;
    s.self = n->settings.self != 0 && !n->frozen;
    Real fastest = 0;
    for (std::uint32_t i = 0; i < n->points; ++i) {
      const std::uint32_t from = n->first + i, to = s.first + i;
      all.position[to] = particles.start[from], all.mass[to] = particles.mass[from];
      all.delta_position[to] = {0, 0, 0, particles.inv_mass[from]};
      s.pinned = s.pinned || particles.inv_mass[from] == 0;
      const Vec3 v = particles.inv_mass[from] != 0 ? particles.velocity[from] : Vec3(0, 0, 0);
      all.velocity[to] = {v[0], v[1], v[2], particles.inv_mass[from]};
      fastest = std::max(fastest, dot(v, v));
    }
    s.fastest = std::sqrt(fastest);
    const Real steps = std::ceil(c.h * s.fastest / (kTravelOfStep * s.thickness));
    s.steps = static_cast<std::int32_t>(clamp(steps, 1, kMaxSteps));
    all.list.push_back(s);
    for (const Attachment& a : attachments)
      if (a.net == n->object)
        all.anchors.push_back({static_cast<std::uint32_t>(all.list.size() - 1), s.first + a.point - n->first, a.body});
  }
}

// Calls f(net, its surface) for nets that collide.
template <class F>
void Springs::Impl::each_surface(F&& f) {
  Surfaces& all = store.get<Surfaces>();
  for (const Surface& s : all.list)
    if (objects.kind(s.object) == kNetKind) f(net(s.object), s, all);
}

// Before the integrator: displacements at the start of the substep.
void Springs::Impl::mark_surfaces(StepContext&) {
  each_surface([&](Net& n, const Surface& s, Surfaces& all) {
    for (std::uint32_t i = 0; i < s.count; ++i)
      all.before[s.first + i].set(particles.position[n.first + i] - particles.start[n.first + i]);
  });
}

// After the integrator: its displacement as a constant velocity.
void Springs::Impl::coast_surfaces(StepContext& c) {
  surface_end.resize(store.get<Surfaces>().size()), surface_velocity.resize(surface_end.size());
  each_surface([&](Net& n, const Surface& s, Surfaces& all) {
    for (std::uint32_t i = 0; i < s.count; ++i) {
      const std::uint32_t from = n.first + i, to = s.first + i;
      const Real w = particles.inv_mass[from];
      const Vec3 end = particles.position[from] - particles.start[from];
      const Vec3 v = w != 0 ? Vec3((end - all.before[to].vec()) / c.h) : Vec3(0, 0, 0);
      surface_end[to] = end, surface_velocity[to] = v;
      // pinned points are at the end already: the net may have been quarantined in this substep
      const Vec3 from_here = w != 0 ? all.before[to].vec() : end;
      all.delta_position[to] = {from_here[0], from_here[1], from_here[2], w};
      all.velocity[to] = {v[0], v[1], v[2], w};
    }
  });
}

// After the contact loop: adds the changes by contact.
void Springs::Impl::follow_surfaces(StepContext&) {
  each_surface([&](Net& n, const Surface& s, Surfaces& all) {
    for (std::uint32_t i = 0; i < s.count; ++i) {
      const std::uint32_t to = n.first + i, from = s.first + i;
      const Vec3 gain = all.velocity[from].vec() - surface_velocity[from];
      if (particles.inv_mass[to] == 0 || gain.isZero(0)) continue;
      particles.velocity[to] += gain;
      particles.move(to, all.delta_position[from].vec() - surface_end[from]);
    }
  });
}

}  // namespace feder
