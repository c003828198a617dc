// Points as spheres: a square for each, on which the fragments find the sphere and its depth.
#include <cstddef>

#include "view/layers.h"
#include "view/shaders.h"

namespace feder::view {

PointLayer::PointLayer(const Gl& gl)
    : gl_(gl), lit_(make_program(gl, "points", kPointVertex, kPointFragment, true)),
      depth_(make_program(gl, "points (depth)", kPointVertex, kPointDepthFragment, false)),
      plain_(lit_->uniform("plain")), range_(lit_->uniform("range")), orthographic_(depth_->uniform("orthographic")),
      points_(gl), array_(gl) {}

void PointLayer::upload(const Frame& f) { points_.fill(f.points, GL_STREAM_DRAW); }

void PointLayer::draw(const Frame& f, const Pass& pass) {
  if (f.point_groups.empty() || (pass.stage != Stage::opaque && pass.stage != Stage::shadow)) return;
  const bool shadow = pass.stage == Stage::shadow;
  (shadow ? depth_ : lit_)->use();
  if (shadow) gl_.Uniform1i(orthographic_, 1);
  array_.bind();
  for (const PointGroup& g : f.point_groups) {
    points_.bind();
    array_.attributes<Point>({{0, 4, offsetof(Point, position)}, {1, 1, offsetof(Point, value)}}, g.first, 1);
    if (!shadow) {
      gl_.Uniform4f(plain_, g.color.r / 255.0f, g.color.g / 255.0f, g.color.b / 255.0f, g.scalar ? -1.0f : 1.0f);
      gl_.Uniform2f(range_, g.low, g.high);
    }
    pass.draw_squares(g.count);
  }
}

}  // namespace feder::view
