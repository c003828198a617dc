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
      if (c.toggles.meshes && has_faces) add_faces(c, *particles, net, faces->second);
      if (c.toggles.springs) add_springs(c, *springs, *particles, net, has_faces ? 1.0f : 2.5f);
      if (c.toggles.points) add_points(c, *springs, *particles, net, has_faces);
      const std::string& name = c.world.objects().name(net.object);
      if (c.toggles.labels && !name.empty() && net.count > 0)
        add_label(c.frame, particles->position[net.first], name, rgb(0x1d2126));
    }
  }

 private:
  static Color color_of(const Collecting& c, ObjectId net) {
    if (const auto own = c.appearance.colors.find(net); own != c.appearance.colors.end()) return rgb(own->second);
    const std::string_view stem = name_stem(c.world.objects().name(net));
    return group_color(stem.empty() ? "net" : stem, net.slot);
  }

  static void include_bounds(Frame& f, const Particles& p, const Springs::NetInfo& net) {
    Bounds b;
    for (std::uint32_t i = net.first; i < net.first + net.count; ++i) {
      float x[3];
      put(x, p.position[i]);
      b.include(x, static_cast<float>(p.radius[i]));
    }
    f.bounds.include(b), f.moving.include(b);
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

  // Area-weighted normals.
  static void add_faces(Collecting& c, const Particles& p, const Springs::NetInfo& net,
                        const std::vector<std::uint32_t>& faces) {
    Frame& f = c.frame;
    DynamicMesh mesh;
    mesh.object = net.object, mesh.color = color_of(c, net.object);
    mesh.first_vertex = static_cast<std::uint32_t>(f.vertices.size()), mesh.vertex_count = net.count;
    mesh.first_index = static_cast<std::uint32_t>(f.indices.size());
    mesh.index_count = static_cast<std::uint32_t>(faces.size());
    for (std::uint32_t i = 0; i < net.count; ++i) {
      MeshVertex v{};
      put(v.position, p.position[net.first + i]);
      f.vertices.push_back(v);
    }
    f.indices.insert(f.indices.end(), faces.begin(), faces.end());
    smooth_normals(f, mesh);
    f.meshes.push_back(mesh);
  }

  static void add_points(Collecting& c, const Springs& springs, const Particles& p, const Springs::NetInfo& net,
                         bool has_faces) {
    Frame& f = c.frame;
    PointGroup group;
    group.first = static_cast<std::uint32_t>(f.points.size());
    group.object = net.object, group.color = color_of(c, net.object);
    const Real dot = dot_radius(springs, net);
    for (std::uint32_t i = net.first; i < net.first + net.count; ++i) {
      const bool pinned = p.inv_mass[i] == 0;
      if (has_faces && !pinned) continue;  // the faces show where it is
      Point point{};
      put(point.position, p.position[i]);
      point.radius = static_cast<float>(p.radius[i] > 0 ? p.radius[i] : dot);
      point.value = static_cast<float>(length(p.velocity[i]));
      f.points.push_back(point);
    }
    group.count = static_cast<std::uint32_t>(f.points.size()) - group.first;
    if (group.count > 0) f.point_groups.push_back(group);
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

void smooth_normals(Frame& f, const DynamicMesh& mesh) {
  MeshVertex* v = f.vertices.data() + mesh.first_vertex;
  const std::uint32_t* index = f.indices.data() + mesh.first_index;
  for (std::uint32_t t = 0; t + 2 < mesh.index_count; t += 3) {
    const float *a = v[index[t]].position, *b = v[index[t + 1]].position, *c = v[index[t + 2]].position;
    const float u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, w[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    const float n[3] = {u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]};
    for (std::uint32_t k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i) v[index[t + k]].normal[i] += n[i];
  }
  for (std::uint32_t i = 0; i < mesh.vertex_count; ++i) {
    float* n = v[i].normal;
    const float size = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (size > 0)
      n[0] /= size, n[1] /= size, n[2] /= size;
    else
      n[1] = 1;
  }
}

Row view_springs() {
  return {"springs", [] { return std::unique_ptr<FrameSource>(new SpringsSource); }};
}

}  // namespace feder::view
