// Cloth: triangles with smooth normals, seen from both sides. Pinned vertices get
// a mark.
#include <algorithm>

#include "feder/cloth.h"
#include "state/cloth_vertices.h"
#include "view/collector.h"

namespace feder::view {
namespace {

class ClothSource final : public FrameSource {
 public:
  void collect(Collecting& c) override {
    Cloth* cloth = c.world.find<Cloth>();
    if (!cloth) return;
    for (std::size_t n = 0; n < cloth->cloth_count(); ++n) {
      const Cloth::Info sheet = cloth->info(n);
      cloth->smooth_positions(sheet.object, points_);
      Bounds b;
      for (const Vec3& p : points_) {
        float x[3];
        put(x, p);
        b.include(x, static_cast<float>(sheet.thickness / 2));
      }
      c.frame.bounds.include(b), c.frame.moving.include(b);
      if (c.toggles.meshes) add_mesh(c, sheet);
      if (c.toggles.points) add_pins(c, *cloth, sheet);
      const std::string& name = c.world.objects().name(sheet.object);
      if (c.toggles.labels && !name.empty()) add_label(c.frame, points_[0], name, rgb(0x1d2126));
    }
  }

 private:
  static Color color_of(const Collecting& c, ObjectId object) {
    if (const auto own = c.appearance.colors.find(object); own != c.appearance.colors.end()) return rgb(own->second);
    const std::string_view stem = name_stem(c.world.objects().name(object));
    return group_color(stem.empty() ? "cloth" : stem, object.slot);
  }

  void add_mesh(Collecting& c, const Cloth::Info& sheet) const {
    Frame& f = c.frame;
    DynamicMesh mesh;
    mesh.object = sheet.object, mesh.color = color_of(c, sheet.object);
    mesh.first_vertex = static_cast<std::uint32_t>(f.vertices.size()), mesh.vertex_count = sheet.count;
    mesh.first_index = static_cast<std::uint32_t>(f.indices.size());
    mesh.index_count = static_cast<std::uint32_t>(sheet.triangles.size());
    for (const Vec3& p : points_) {
      MeshVertex v{};
      put(v.position, p);
      f.vertices.push_back(v);
    }
    f.indices.insert(f.indices.end(), sheet.triangles.begin(), sheet.triangles.end());
    smooth_normals(f, mesh);
    f.meshes.push_back(mesh);
  }

  void add_pins(Collecting& c, const Cloth& cloth, const Cloth::Info& sheet) const {
    Frame& f = c.frame;
    PointGroup group;
    group.first = static_cast<std::uint32_t>(f.points.size());
    group.object = sheet.object, group.color = rgb(0x3a3f45);
    for (std::uint32_t i = 0; i < sheet.count; ++i) {
      if (cloth.vertices().inv_mass[sheet.first + i] != 0) continue;
      Point p{};
      put(p.position, points_[i]);
      p.radius = static_cast<float>(sheet.thickness);
      f.points.push_back(p);
    }
    group.count = static_cast<std::uint32_t>(f.points.size()) - group.first;
    if (group.count > 0) f.point_groups.push_back(group);
  }

  std::vector<Vec3> points_;
};
}  // namespace

Row view_cloth() {
  return {"cloth", [] { return std::unique_ptr<FrameSource>(new ClothSource); }};
}

}  // namespace feder::view
