// Fluids: in space the surface of the liquid (fluid/liquid_surface.h), else, or as the toggles say, particles as balls
// that touch at rest, coloured by speed, density or pressure. Beyond kMostLiquid particles balls are cheaper, and
// drawn.
#include <algorithm>

#include "feder/fluid.h"
#include "fluid/liquid_surface.h"
#include "view/collector.h"

namespace feder::view {
namespace {

constexpr std::size_t kMostLiquid = 150'000;  // 30 ms of one core

class FluidSource final : public FrameSource {
 public:
  void collect(Collecting& c) override {
    Fluid* fluid = c.world.find<Fluid>();
    if (!fluid) return;
    c.world.objects().for_each(kFluidKind, [&](ObjectId id) { add(c, *fluid, id); });
  }

 private:
  void add(Collecting& c, Fluid& fluid, ObjectId id) {
    Frame& f = c.frame;
    fluid.positions(id, x_);
    const float radius = 0.5f * static_cast<float>(fluid.desc(id).spacing);
    Bounds b;
    const std::optional<Color> own = c.own_color(id);
    if (c.toggles.liquid && c.toggles.meshes && f.dimension == 3 && x_.size() <= kMostLiquid) {
      surface_.build(x_, fluid.desc(id).spacing, false, mesh_);
      if (!mesh_.triangles.empty()) {
        for (const Vec3& x : x_) b.include(to_float3(x), radius);
        add_bounds(f, b);
        return add_mesh(f, id, own.value_or(rgb(0x3b7dbb)), mesh_.vertices, mesh_.triangles);
      }
    }
    PointGroup group = begin_points(f, id, own.value_or(rgb(0x3b7dbb)));
    value_.assign(x_.size(), 0);
    if (!own) values(c, fluid, id, group);
    for (std::size_t i = 0; i < x_.size(); ++i) {
      const Point p{to_float3(x_[i]), radius, value_[i]};
      b.include(p.position, radius);
      if (c.toggles.points) f.points.push_back(p);
    }
    add_bounds(f, b);
    end_points(f, group);
  }

  // What the points are coloured by, and the ends of its scale: 0 to the largest now (of the speeds, to the 98th part
  // in a hundred, so that one drop does not darken the rest).
  void values(Collecting& c, Fluid& fluid, ObjectId id, PointGroup& g) {
    const std::string_view by = c.toggles.point_scalar;
    if (by == "none" || x_.empty()) return;
    g.scalar = c.toggles.point_scalar;
    if (by == "density" || by == "pressure") {
      if (by == "density")
        c.world.query<Fluid>()->densities(id, number_);
      else
        c.world.query<Fluid>()->pressures(id, number_);
      for (std::size_t i = 0; i < x_.size(); ++i) value_[i] = static_cast<float>(number_[i]);
    } else {
      fluid.velocities(id, v_);
      for (std::size_t i = 0; i < x_.size(); ++i) value_[i] = static_cast<float>(length(v_[i]));
    }
    if (by == "density") {
      g.low = 0.9f, g.high = 1.1f;
      return;
    }
    sorted_ = value_;
    const auto at = sorted_.begin() + static_cast<std::ptrdiff_t>(sorted_.size() * 98 / 100);
    std::nth_element(sorted_.begin(), at, sorted_.end());
    g.low = 0, g.high = std::max(*at, by == "speed" ? 0.1f : 1.0f);
  }

  std::vector<Vec3> x_, v_;
  std::vector<Real> number_;
  std::vector<float> value_, sorted_;
  LiquidSurface surface_;
  IsoMesh mesh_;
};

}  // namespace

Row view_fluid() { return {"fluid", make_source<FluidSource>}; }

}  // namespace feder::view
