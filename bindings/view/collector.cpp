#include "view/collector.h"

#include <algorithm>
#include <cstdio>
#include <cstring>

namespace feder::view {

#include "view_declare.inc"

std::span<const Row> frame_sources() {
  static const Row rows[] = {
#include "view_rows.inc"
  };
  return rows;
}

void Frame::clear() {
  instances.clear(), batches.clear(), grounds.clear();
  vertices.clear(), indices.clear(), meshes.clear();
  points.clear(), point_groups.clear(), liquids.clear(), foam.clear(), notes.clear();
  lines.clear(), outlines.clear(), overlay_lines.clear(), labels.clear(), plots.clear();
  moving = bounds = Bounds{};
  deeper_volumes = deeper_cells = false;
}

namespace {

Label label_at(const Vec3& at, Color color, std::string_view text) {
  Label label{to_float3(at), color, {}};
  text.copy(label.text, sizeof label.text - 1);
  return label;
}

void collect_plots(World& world, Frame& frame) {
  const auto add = [&frame](std::string_view name, double value) {
    PlotValue p{};
    name.copy(p.name, sizeof p.name - 1);
    p.value = value;
    frame.plots.push_back(p);
  };
  const Energy e = world.energy();
  add("energy.kinetic_J", e.kinetic), add("energy.potential_J", e.potential), add("energy.elastic_J", e.elastic);
  for (const Residual& r : world.residuals()) add(r.name, r.value);
}

// What begins, ends and hits: its name where it happened.
void collect_marks(World& world, Frame& frame) {
  for (const Event& e : world.events().list())
    if (e.kind.has(EventKind::kPair) && e.kind != EventKind::contact_stay)
      frame.labels.push_back(label_at(e.point, rgb(0xd83a8c), e.kind.text()));
}

}  // namespace

Collector::Collector(std::span<const Row> sources) {
  for (const Row& row : sources) sources_.push_back(row.make());
}

void Collector::collect(World& world, const lua::Appearance* appearance, const Toggles& toggles, Frame& frame) {
  frame.clear();
  frame.time = world.time();
  frame.step = world.step_count();
  frame.dimension = world.desc().dimension;
  Collecting c{world, appearance ? *appearance : no_appearance_, toggles, geometry_, frame};
  for (const auto& source : sources_) source->collect(c);
  if (toggles.plots) collect_plots(world, frame);
  if (toggles.marks) collect_marks(world, frame);
  if (frame.geometries.size() != geometry_.geometries().size() || frame.geometries != geometry_.geometries())
    frame.geometries = geometry_.geometries();
}

void add_line(std::vector<Line>& lines, const Vec3& a, const Vec3& b, Color color, float width) {
  lines.push_back({to_float3(a), to_float3(b), color, color, width});
}

void add_arrow(std::vector<Line>& lines, const Vec3& from, const Vec3& along, Color color, float width) {
  const Real size = length(along);
  if (!(size > 0) || !is_finite(size)) return;
  const Vec3 to = from + along, n = along / size;
  Vec3 u, v;
  tangent_frame(n, u, v);
  add_line(lines, from, to, color, width);
  const Real head = Real(0.2) * size;
  for (const Real side : {Real(-1), Real(1)})
    add_line(lines, to, Vec3(to - head * n + Real(0.4) * side * head * u), color, width);
}

void add_box(std::vector<Line>& lines, const Aabb& box, Color color) {
  if (box.empty() || !is_finite(box.lo) || !is_finite(box.hi)) return;
  for (int axis = 0; axis < 3; ++axis)
    for (int corner = 0; corner < 4; ++corner) {
      Vec3 a = box.lo;
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      if (corner & 1) a[u] = box.hi[u];
      if (corner & 2) a[v] = box.hi[v];
      Vec3 b = a;
      b[axis] = box.hi[axis];
      add_line(lines, a, b, color, 1);
    }
}

std::optional<Color> Collecting::own_color(ObjectId object) const {
  const auto own = appearance.colors.find(object);
  return own != appearance.colors.end() ? std::optional(rgb(own->second)) : std::nullopt;
}

Color Collecting::color(ObjectId object, std::string_view group) const {
  const std::string_view stem = name_stem(world.objects().name(object));
  return own_color(object).value_or(group_color(stem.empty() ? group : stem, object.slot));
}

void Collecting::label(ObjectId object, const Vec3& at, Color color) const {
  const std::string& name = world.objects().name(object);
  if (toggles.labels && !name.empty()) frame.labels.push_back(label_at(at, color, name));
}

void add_mesh(Frame& f, ObjectId object, Color color, std::span<const Vec3> points,
              std::span<const std::uint32_t> faces) {
  f.meshes.push_back({static_cast<std::uint32_t>(f.vertices.size()), static_cast<std::uint32_t>(points.size()),
                      static_cast<std::uint32_t>(f.indices.size()), static_cast<std::uint32_t>(faces.size()), color,
                      object});
  for (const Vec3& p : points) f.vertices.push_back({to_float3(p), {}});
  f.indices.insert(f.indices.end(), faces.begin(), faces.end());
  MeshVertex* v = f.vertices.data() + f.meshes.back().first_vertex;
  for (std::size_t t = 0; t + 2 < faces.size(); t += 3) {
    const Float3 a = v[faces[t]].position;
    const Float3 n = cross(v[faces[t + 1]].position - a, v[faces[t + 2]].position - a);
    for (std::size_t k = 0; k < 3; ++k) v[faces[t + k]].normal = v[faces[t + k]].normal + n;
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float size = length(v[i].normal);
    v[i].normal = size > 0 ? v[i].normal / size : Float3{v[i].normal.x, 1, v[i].normal.z};
  }
}

PointGroup begin_points(const Frame& frame, ObjectId object, Color color) {
  PointGroup group;
  group.first = static_cast<std::uint32_t>(frame.points.size());
  group.color = color, group.object = object;
  return group;
}

void end_points(Frame& frame, PointGroup group) {
  group.count = static_cast<std::uint32_t>(frame.points.size()) - group.first;
  if (group.count > 0) frame.point_groups.push_back(group);
}

void add_bounds(Frame& frame, const Bounds& moving) { frame.bounds.include(moving), frame.moving.include(moving); }

}  // namespace feder::view
