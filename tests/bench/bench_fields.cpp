// Nanoseconds of what is asked of distance fields: queries in the band, and whole tests of pairs at rest.
//   bench_fields [repeats = 200] [part of the name of the rows]
// All rows take turns within a repeat and the least of many repeats counts, because the machine may be shared.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "base/rng.h"
#include "feder/sdf.h"
#include "geom/sdf.h"
#include "narrow/narrow_phase.h"

using namespace feder;

namespace {

struct Row {
  std::string name;
  double count;  // of what one call does
  std::function<void()> call;
  double least = 1e30;  // s
};

double seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

ShapePtr torus(Real R, Real r, Real spacing) {
  SdfDesc d;
  d.function = [R, r](double x, double y, double z) {
    const double q = std::sqrt(x * x + y * y) - double(R);
    return std::sqrt(q * q + z * z) - double(r);
  };
  const Real w = Real(2.2) * (R + r);
  d.size = Vec3(w, w, Real(2.6) * r), d.spacing = spacing;
  return make_sdf(d);
}

ShapePtr field_of(const ShapePtr& shape, Real spacing) {
  SdfDesc d;
  d.shape = shape, d.spacing = spacing;
  return make_sdf(d);
}

constexpr Real kMargin = Real(0.02);  // m, as a world has it for bodies of this size
double sink = 0;

void add_queries(std::vector<Row>& rows) {
  static const ShapePtr ball = field_of(make_sphere(1), Real(2.2) / 128);
  const DistanceField& field = static_cast<const Sdf&>(*ball).field();
  constexpr int kCount = 4096;
  static std::vector<Vec3> places;
  Rng rng(7);
  Vec3 at(1, 0, 0);
  for (int i = 0; i < kCount; ++i) {  // a walk along the surface
    const auto some = [&rng] { return rng.uniform(Real(-0.005), Real(0.005)); };
    const Real x = some(), y = some(), z = some();
    at += Vec3(x, y, z);
    at *= (1 + 2 * some()) / length(at);
    places.push_back(at);
  }
  rows.push_back({"value", kCount, [&field] {
                    for (const Vec3& p : places) sink += double(field.at(p));
                  }});
  rows.push_back({"value and slope", kCount, [&field] {
                    Vec3 g;
                    for (const Vec3& p : places) sink += double(field.at(p, g) + g[0]);
                  }});
  rows.push_back({"value and smooth slope", kCount, [&field] {
                    Vec3 g;
                    for (const Vec3& p : places) sink += double(field.smooth_at(p, g) + g[0]);
                  }});
}

void add_pair(std::vector<Row>& rows, const char* name, ShapePtr a, Pose pa, ShapePtr b, Pose pb) {
  static const NarrowPhase narrow("auto");
  rows.push_back({name, 1, [=] {
                    PairCache cache;
                    Manifold m[kMaxManifolds];
                    const int n = narrow.collide(*a, pa, *b, pb, kMargin, cache, m);
                    sink += n;
                  }});
}

}  // namespace

int main(int argc, char** argv) {
  const int repeats = argc > 1 ? std::atoi(argv[1]) : 200;
  std::vector<Row> rows;
  add_queries(rows);
  const Quat across = from_axis_angle(Vec3(0, 1, 0), Real(1.5707963));
  const Quat flat = from_axis_angle(Vec3(1, 0, 0), Real(1.5707963));
  const ShapePtr ring = torus(Real(0.5), Real(0.1), Real(0.02)), cube = field_of(make_box(1, 1, 1), Real(1) / 32);
  const ShapePtr ground = make_plane(Vec3(0, 1, 0), 0), slab = make_box(4, 1, 4), peg = make_cylinder(Real(0.05), 1);
  const Real near = Real(-0.0005);
  add_pair(rows, "ring in ring", ring, {Vec3(0, 0, 0), {}}, ring, {Vec3(0, Real(-0.8) + near, 0), across});
  add_pair(rows, "ring flat on plane", ring, {Vec3(0, Real(0.1) + near, 0), flat}, ground, {});
  add_pair(rows, "ring flat on box", ring, {Vec3(0, Real(0.6) + near, 0), flat}, slab, {});
  add_pair(rows, "ring flat on ring", ring, {Vec3(0, Real(0.2) + near, 0), flat}, ring, {Vec3(0, 0, 0), flat});
  add_pair(rows, "ring on peg", ring, {Vec3(0, Real(-0.35) + near, 0), {}}, peg, {Vec3(0, 0, 0), flat});
  add_pair(rows, "cube on plane", cube, {Vec3(0, Real(0.5) + near, 0), {}}, ground, {});
  add_pair(rows, "cube on box", cube, {Vec3(0, 1 + near, 0), {}}, slab, {});
  add_pair(rows, "cube on cube", cube, {Vec3(Real(0.1), 1 + near, 0), {}}, cube, {});
  add_pair(rows, "box on cube", make_box(1, 1, 1), {Vec3(Real(0.1), 1 + near, 0), {}}, cube, {});
  const std::string part = argc > 2 ? argv[2] : "";
  std::erase_if(rows, [&part](const Row& row) { return row.name.find(part) == std::string::npos; });
  for (int i = 0; i < repeats; ++i)
    for (Row& row : rows) {
      const double start = seconds();
      row.call();
      row.least = std::min(row.least, seconds() - start);
    }
  for (const Row& row : rows) std::printf("%-24s %10.0f ns\n", row.name.c_str(), 1e9 * row.least / row.count);
  return sink == 0.5;
}
