// world:rope{ ... }: points, or a straight rope between two places; stiffness, pins, and what it does with others.

#include "lua/buffer.h"
#include "lua/rope_part.h"
#include "lua/shapes.h"

namespace feder::lua {
namespace {

struct RopeReading : Making<RopeDesc> {
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();
  std::uint32_t segments = 20;
};

void read_rope_points(Options& o, const OptionRow&, RopeReading& desc) {
  const bool given = points_option(o, "points", desc.points);
  for (const char* key : {"from", "to", "segments"}) {
    if (given && o.has(key)) o.raise(key, "goes with a straight rope; points say where this one lies");
    if (!given && !o.has(key) && std::string_view(key) != "segments")
      o.raise(key, "expected points, or from and to, got nil");
  }
}

// Point numbers; "first" and "last", also with "_clamped" when the direction is held too.
void read_rope_pins(Options& o, const OptionRow&, RopeReading& desc) {
  if (!o.push_any("pins")) return;
  lua_State* L = o.L();
  const std::uint32_t count = desc.points.empty() ? desc.segments + 1 : static_cast<std::uint32_t>(desc.points.size());
  const auto one = [&](int index, const std::string& what) {
    if (lua_type(L, index) == LUA_TNUMBER) return desc.pins.push_back(check_index(L, index, what, count));
    static const char kKnown[] = "expected a point number, \"first\", \"last\", \"first_clamped\" or \"last_clamped\"";
    if (lua_type(L, index) != LUA_TSTRING) fail(L, what + ": " + kKnown + ", got " + describe(L, index));
    const std::string name = lua_tostring(L, index);
    if (name == "first" || name == "first_clamped")
      desc.pins.push_back(0), desc.clamp_first = desc.clamp_first || name != "first";
    else if (name == "last" || name == "last_clamped")
      desc.pins.push_back(count - 1), desc.clamp_last = desc.clamp_last || name != "last";
    else
      fail(L, what + ": " + kKnown + ", got '" + name + "'");
  };
  if (lua_type(L, -1) == LUA_TTABLE)
    each_entry(L, -1, [&](lua_Integer k) { one(-1, o.path("pins") + "[" + std::to_string(k) + "]"); });
  else
    one(-1, o.path("pins"));
  lua_pop(L, 1);
}

constexpr Option<RopeReading> kRope[] = {
    field<&RopeDesc::name>("name"),
    special("points", "list of vectors or buffer", read_rope_points, "m"),
    field<&RopeReading::from>("from", "m"),
    field<&RopeReading::to>("to", "m"),
    field<&RopeReading::segments>("segments", "", {1, 100000}),
    field<&RopeDesc::velocity>("velocity", "m/s"),
    field<&RopeDesc::radius>("radius", "m", kPositive),
    field<&RopeDesc::density>("density", "kg/m3", kPositive),
    field<&RopeDesc::stretch>("stretch", "N", kPositive),
    field<&RopeDesc::bend>("bend", "N m2", kNotNegative),
    field<&RopeDesc::damping>("damping", "s", kNotNegative),
    field<&RopeDesc::drag>("drag", "", kNotNegative),
    field<&RopeDesc::friction>("friction", "", kNotNegative),
    field<&RopeDesc::self_collision>("self_collision"),
    field<&RopeDesc::gravity_scale>("gravity_scale", "", kGravityScale),
    field<&RopeDesc::group>("group", "", kBits),
    field<&RopeDesc::mask>("mask", "", kBits),
    field<&RopeDesc::substeps>("substeps", "", {1, 1000}).unset(),
    special("pins", "list of vertex numbers or names", read_rope_pins),
    special("color", "color", read_color<RopeReading>),
    later<RopeReading>("tags", kWordsType),
};

}  // namespace

std::vector<OptionInfo> rope_rows() { return describe_rows(kRope); }

ObjectId world_rope(WorldRecord& r, lua_State* L) {
  if (r.planar()) fail_here(L, "expected a world of dimension 3: ropes have no 2D section; take a net");
  RopeReading rope = read_description(L, r, kRope);
  if (rope.points.empty()) {
    if (!(length(Vec3(rope.to - rope.from)) > 0)) fail_here(L, "to: expected another place than from");
    for (std::uint32_t i = 0; i <= rope.segments; ++i)
      rope.points.push_back(rope.from +
                            static_cast<Real>(i) / static_cast<Real>(rope.segments) * (rope.to - rope.from));
  }
  const ObjectId id = r.world->need<Rope>().add_rope(rope);
  if (rope.painted) r.appearance.colors[id] = rope.color;
  return id;
}

}  // namespace feder::lua
