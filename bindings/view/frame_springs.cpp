// Mass-spring nets: springs as lines coloured by strain, faces as meshes with smooth normals, points as small balls
// (those that collide with their radius, pinned ones with a mark).
#include <algorithm>
#include <cmath>

#include "feder/net.h"
#include "state/particles.h"
#include "view/collector.h"

namespace feder::view {
namespace {

constexpr Real kFullStrain = Real(0.25);  // strain of the deepest colour

class SpringsSource final : public FrameSource {
 public:
  void collect(Collecting& c) override {
    Springs* springs = c.world.find<Springs>();
    const Particles* particles = c.world.store().find<Particles>();
    if (!springs || !particles) return;
    for (std::size_t n = 0; n < springs->net_count(); ++n) {
      const Springs::NetInfo net = springs->net_info(n);
      include_bounds(c.frame, *particles, net);
      const auto faces = c.appearance.faces.find(net.object);
      const bool has_faces = faces != c.appearance.faces.end() && !faces->second.empty();
      if (c.toggles.meshes && has_faces)
        add_mesh(c.frame, net.object, c.color(net.object, "net"), points_of(*particles, net), faces->second);
      if (c.toggles.springs) add_springs(c, *springs, *particles, net, has_faces ? 1.0f : 2.5f);
      if (c.toggles.points) add_points(c, *springs, *particles, net, has_faces);
      if (net.count > 0) c.label(net.object, particles->position[net.first], rgb(0x1d2126));
    }
  }

 private:
  static std::span<const Vec3> points_of(const Particles& p, const Springs::NetInfo& net) {
    return std::span(p.position).subspan(net.first, net.count);
  }

  static void include_bounds(Frame& f, const Particles& p, const Springs::NetInfo& net) {
    Bounds b;
    for (std::uint32_t i = net.first; i < net.first + net.count; ++i)
      b.include(to_float3(p.position[i]), static_cast<float>(p.radius[i]));
    add_bounds(f, b);
  }

  static void add_springs(Collecting& c, const Springs& springs, const Particles& p, const Springs::NetInfo& net,
                          float width) {
    const SpringView s = springs.springs(net.object);
    for (std::size_t k = 0; k < s.i.size(); ++k) {
      if (!s.alive[k]) continue;
      const Vec3 &a = p.position[net.first + s.i[k]], &b = p.position[net.first + s.j[k]];
      const Real strain = s.rest_length[k] > 0 ? length(b - a) / s.rest_length[k] - 1 : 0;
      add_line(c.frame.lines, a, b, strain_color(static_cast<float>(strain / kFullStrain)), width);
    }
  }

  static void add_points(Collecting& c, const Springs& springs, const Particles& p, const Springs::NetInfo& net,
                         bool has_faces) {
    Frame& f = c.frame;
    const PointGroup group = begin_points(f, net.object, c.color(net.object, "net"));
    const Real dot = dot_radius(springs, net);
    for (std::uint32_t i = net.first; i < net.first + net.count; ++i) {
      const bool pinned = p.inv_mass[i] == 0;
      if (has_faces && !pinned) continue;  // the faces show where it is
      f.points.push_back({to_float3(p.position[i]), static_cast<float>(p.radius[i] > 0 ? p.radius[i] : dot),
                          static_cast<float>(length(p.velocity[i]))});
    }
    end_points(f, group);
  }

  // Points without a size of their own are drawn as dots of 7 % of the mean rest length.
  static Real dot_radius(const Springs& springs, const Springs::NetInfo& net) {
    const SpringView s = springs.springs(net.object);
    Real sum = 0;
    for (const Real r : s.rest_length) sum += r;
    return s.rest_length.empty() ? Real(0.05) : Real(0.07) * sum / static_cast<Real>(s.rest_length.size());
  }
};

}  // namespace

Row view_springs() { return {"springs", make_source<SpringsSource>}; }

}  // namespace feder::view
