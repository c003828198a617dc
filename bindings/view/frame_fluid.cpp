// Fluids as liquids: in space by their surface (fluid/liquid_surface.h), smoothed, with spray as droplets; beyond
// Toggles::liquid_limit particles by splats, and with a note; in a plane as a sheet. As the toggles say, particles as
// balls that touch at rest, coloured by speed, density or pressure.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "feder/fluid.h"
#include "fluid/liquid_surface.h"
#include "view/collector.h"
#include "view/liquid_shape.h"

namespace feder::view {
namespace {

constexpr std::uint32_t kWater = 0x3b8dbb, kDroplet = 0xe6f0f5;
constexpr float kClearWater = 0.9f, kClearColored = 0.5f;  // transparency of liquids that state none
constexpr float kDropletSize = 0.22f;                      // spacings
constexpr Real kCalm = Real(0.2);        // of the speed of waves as deep as the liquid: below, nothing foams
constexpr std::size_t kSmooth = 15'000;  // particles up to which cells are finer, and the skin is smoothed more

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
    if (c.toggles.liquid && c.toggles.meshes && !x_.empty()) return add_liquid(c, fluid, id, own);
    PointGroup group = begin_points(f, id, own.value_or(rgb(kWater)));
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

  void add_liquid(Collecting& c, Fluid& fluid, ObjectId id, std::optional<Color> own) {
    Frame& f = c.frame;
    const Real spacing = fluid.desc(id).spacing;
    Liquid l;
    l.color = own.value_or(rgb(kWater));
    const auto stated = c.appearance.transparencies.find(id);
    l.transparency = stated != c.appearance.transparencies.end() ? stated->second : own ? kClearColored : kClearWater;
    l.depth =
        static_cast<float>(spacing) * std::pow(static_cast<float>(x_.size()), 1 / static_cast<float>(f.dimension));
    if (f.dimension == 2)
      add_points(f, id, l, x_, 0.5f * static_cast<float>(spacing), kPrismDepth / 2 - 0.001f * l.depth);
    else if (x_.size() <= c.toggles.liquid_limit)
      add_surface(c, fluid, id, l, spacing);
    else
      add_splats(c, id, l, spacing);
  }

  void add_surface(Collecting& c, Fluid& fluid, ObjectId id, Liquid l, Real spacing) {
    Frame& f = c.frame;
    const Real calm = kCalm * std::sqrt(length(c.world.desc().gravity) * static_cast<Real>(l.depth));
    if (calm > 0) fluid.velocities(id, v_);
    shape_.sort(x_, v_, spacing, calm);
    surface_.build(shape_.bulk(), spacing, false, mesh_);
    if (!mesh_.triangles.empty()) {
      std::span<float> foam;
      if (shape_.foams()) {
        l.first_foam = static_cast<std::uint32_t>(f.foam.size());
        for (const Vec3& v : mesh_.vertices) f.foam.push_back(shape_.foam(v));
        foam = std::span(f.foam).subspan(l.first_foam);
      }
      smooth_mesh(mesh_.vertices, mesh_.triangles, foam, x_.size() <= kSmooth ? 3 : 2, scratch_, weights_);
      l.mesh = static_cast<std::uint32_t>(f.meshes.size());
      Color skin = l.color;  // as files of pictures have it, that know no depth
      skin.a = static_cast<std::uint8_t>(255 - 180 * l.transparency);
      add_mesh(f, id, skin, mesh_.vertices, mesh_.triangles);
      f.meshes.back().liquid = static_cast<std::uint32_t>(f.liquids.size());
      f.liquids.push_back(l);
    }
    Bounds b;
    for (const Vec3& x : shape_.bulk()) b.include(to_float3(x), 0.5f * static_cast<float>(spacing));
    add_bounds(f, b);
    PointGroup drops = begin_points(f, id, mixed(rgb(kDroplet), l.color, l.transparency < kClearWater ? 0.7f : 0.4f));
    drops.casts_shadow = false;
    put_points(f, shape_.spray(), kDropletSize * static_cast<float>(spacing), 0);
    end_points(f, drops);
  }

  // The points of a liquid without a mesh.
  static void add_points(Frame& f, ObjectId id, Liquid l, std::span<const Vec3> points, float radius, float z) {
    PointGroup group = begin_points(f, id, l.color);
    group.liquid = static_cast<std::uint32_t>(f.liquids.size());
    group.casts_shadow = f.dimension == 3;
    l.group = static_cast<std::uint32_t>(f.point_groups.size());
    put_points(f, points, radius, z);
    end_points(f, group);
    if (l.group < f.point_groups.size()) f.liquids.push_back(l);
  }

  static void put_points(Frame& f, std::span<const Vec3> points, float radius, float z) {
    Bounds b;
    for (const Vec3& x : points) {
      if (!is_finite(x)) continue;
      Point p{to_float3(x), radius, 0};
      p.position.z += z;
      b.include(p.position, radius);
      f.points.push_back(p);
    }
    add_bounds(f, b);
  }

  void add_splats(Collecting& c, ObjectId id, const Liquid& l, Real spacing) {
    add_points(c.frame, id, l, x_, 0.5f * static_cast<float>(spacing), 0);
    Note note{id, {}};
    std::snprintf(
        note.text, sizeof note.text,
        "%s is drawn as drops: its surface is built up to %zu particles, it has %zu; --show liquid (view: --draw "
        "liquid) builds it all the same, a larger spacing has fewer",
        c.world.objects().describe(id).c_str(), c.toggles.liquid_limit, x_.size());
    c.frame.notes.push_back(note);
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
  std::vector<Vec3> scratch_;
  std::vector<float> weights_;
  LiquidShape shape_;
  LiquidSurface surface_;
  IsoMesh mesh_;
};

}  // namespace

Row view_fluid() { return {"fluid", make_source<FluidSource>}; }

}  // namespace feder::view
