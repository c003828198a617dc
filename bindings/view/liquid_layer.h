// Liquids over a picture of everything else: see-through bodies with a surface. Each is drawn over a copy of what is
// there already, so that it shows what lies behind and in it, other liquids too.
#pragma once
#include <optional>

#include "view/layers.h"

namespace feder::view {

// A framebuffer with a texture, and one for depths where asked for.
struct PixelTarget {
  PixelTarget(const Gl& gl, GLenum format, bool with_depth, int width, int height);
  GlObject frame, color, depth;
  int width, height;
};

class LiquidLayer {
 public:
  LiquidLayer(const Gl& gl, const ShapeLayer& shapes, const PointLayer& points);
  void upload(const Frame& frame);  // after the layers whose buffers it reads
  // Into the bound framebuffer of the target's size, number `into`, with the uniform block and the shadow map in place.
  void draw(const Frame& frame, const Camera& camera, const Target& into, DrawStats& stats);

 private:
  struct Drawing {
    const Frame& frame;
    const Camera& camera;
    const Target& into;
    DrawStats& stats;
    Pass pass(const Gl& gl) const { return {gl, Stage::opaque, stats}; }
  };
  void make_targets(const Target& size, bool splats);
  void copy(const Target& from) const;
  void draw_mesh(const Drawing& d, const Liquid& liquid);
  void draw_splats(const Drawing& d, const Liquid& liquid);
  void draw_sheet(const Drawing& d, const Liquid& liquid);
  void sum_ways(const Drawing& d, const PointGroup& group, float grow, float share);
  void aim_mesh(const DynamicMesh& mesh, std::uint32_t first_foam) const;
  void begin_water(const Drawing& d, const Program& program, const Liquid& liquid) const;
  void clear(const PixelTarget& target, bool with_depth) const;
  void read(GLenum unit, const GlObject& texture) const;

  const Gl& gl_;
  const ShapeLayer& shapes_;
  const PointLayer& points_;
  std::unique_ptr<Program> way_, mesh_, ball_depth_, ball_way_, smooth_, splat_, sheet_;
  Buffer foam_;
  VertexArray mesh_array_, point_array_;
  std::optional<PixelTarget> behind_, ways_, depths_, smoothed_;
};

}  // namespace feder::view
