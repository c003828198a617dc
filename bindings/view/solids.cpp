#include "view/solids.h"

#include <cmath>

#include "feder/types.h"
#include "view/palette.h"

namespace feder::view {

Solid solid(const Instance& in, const Geometry& g) {
  Solid s;
  s.object = in.object, s.color = in.color, s.indices = g.indices;
  const Quat q{Real(in.rotation[0]), Real(in.rotation[1]), Real(in.rotation[2]), Real(in.rotation[3])};
  for (const Vertex& v : g.vertices) {
    Vec3 x = to_vec3(v.position), n = to_vec3(v.normal);
    for (int k = 0; k < 3; ++k) x[k] *= Real(in.scale[k]), n[k] /= Real(in.scale[k]);
    x[1] += Real(v.side * in.stretch);
    s.vertices.push_back(
        {to_float3(to_vec3(in.position) + rotate(q, x)), to_float3(normalized_or(rotate(q, n), vec3(0, 1, 0)))});
  }
  return s;
}

Solid solid(const Ground& ground, const Frame& frame) {
  Vec3 center = Vec3::Zero();
  Real half = 5;
  if (!frame.bounds.empty()) {
    const Vec3 low = to_vec3(frame.bounds.low), high = to_vec3(frame.bounds.high);
    center = (low + high) / 2;
    half = std::max(half, 2 * (high - low).cwiseAbs().maxCoeff());
  }
  const Vec3 n = to_vec3(ground.normal);
  center -= (dot(n, center) - Real(ground.distance)) * n;
  Vec3 u = vec3(1, 0, 0), v = vec3(0, 0, -1);
  if (n[1] < Real(0.9999)) tangent_frame(n, u, v);
  Solid s;
  s.object = ground.object.slot, s.color = ground.color;
  s.indices = {0, 1, 2, 0, 2, 3};
  for (const auto& [a, b] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
    s.vertices.push_back({to_float3(center + half * (Real(a) * u + Real(b) * v)), to_float3(n)});
  return s;
}

Instance ball_instance(const Point& p, Color color, std::uint32_t object) {
  Instance i;
  i.position = p.position, i.scale = {p.radius, p.radius, p.radius};
  i.color = color, i.object = object;
  return i;
}

Color point_color(const PointGroup& group, const Point& point) {
  if (!group.scalar) return group.color;
  return ramp_color((point.value - group.low) / std::max(group.high - group.low, 1e-20f));
}

std::vector<Solid> solids(const Frame& f) {
  std::vector<Solid> all;
  for (const Ground& g : f.grounds) all.push_back(solid(g, f));
  for (const Batch& b : f.batches)
    for (std::uint32_t i = b.first; i < b.first + b.count; ++i)
      all.push_back(solid(f.instances[i], *f.geometries[b.geometry]));
  for (const DynamicMesh& m : f.meshes) {
    Solid s;
    s.object = m.object.slot, s.color = m.color;
    s.vertices.assign(f.vertices.begin() + m.first_vertex, f.vertices.begin() + m.first_vertex + m.vertex_count);
    s.indices.assign(f.indices.begin() + m.first_index, f.indices.begin() + m.first_index + m.index_count);
    all.push_back(std::move(s));
  }
  return all;
}

}  // namespace feder::view
