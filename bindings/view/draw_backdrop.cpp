// Sky and ground. A plane is one large square about the point below the camera's target; its grid keeps a readable
// spacing (a power of ten of metres) and it fades into the sky, so that its end is not seen.
#include <cmath>

#include "feder/types.h"
#include "view/layers.h"
#include "view/shaders.h"

namespace feder::view {

BackdropLayer::BackdropLayer(const Gl& gl)
    : gl_(gl), sky_(make_program(gl, "sky", kBackgroundVertex, kBackgroundFragment, false)),
      ground_(make_program(gl, "ground", kGroundVertex, kGroundFragment, true)), array_(gl) {}

void BackdropLayer::draw_sky(const Pass& pass) {
  sky_->use();
  array_.bind();
  pass.draw_squares(1);
}

void BackdropLayer::draw_grounds(const Frame& f, const Camera& camera, const Pass& pass) {
  if (f.grounds.empty()) return;
  ground_->use();
  array_.bind();
  const bool planar = f.dimension == 2;
  const Real reach = Real(camera.distance) * (planar ? Real(3) : Real(9));
  const Vec3 target = to_vec3(camera.target), eye = to_vec3(camera.eye());
  const auto spacing =
      static_cast<float>(std::pow(10.0, std::floor(std::log10(0.25 * static_cast<double>(camera.distance)))));
  for (const Ground& g : f.grounds) {
    const Vec3 n = to_vec3(g.normal);
    const Real height = dot(n, target) - Real(g.distance);
    if (!planar && dot(n, eye) < Real(g.distance)) continue;  // from inside the ground all is seen
    Vec3 origin = target - height * n, along, over, u = vec3(1, 0, 0), v = vec3(0, 0, 1);
    if (planar) {
      // the cut face, in front of the bodies' middle like their own front faces
      along = reach * cross(vec3(0, 0, 1), n), over = Real(-0.5) * reach * n;
      origin += over + vec3(0, 0, Real(kPrismDepth / 2));
      v = vec3(0, 1, 0);
    } else {
      if (std::abs(n[1]) < Real(0.999)) tangent_frame(n, u, v);
      along = reach * u, over = -reach * cross(n, u);
    }
    const Float3 albedo{g.color.r / 255.0f, g.color.g / 255.0f, g.color.b / 255.0f};
    const std::pair<const char*, Float3> vectors[] = {
        {"origin", to_float3(origin)}, {"along", to_float3(along)}, {"over", to_float3(over)}, {"axis_u", to_float3(u)},
        {"axis_v", to_float3(v)},      {"plane_normal", g.normal},  {"albedo", albedo}};
    for (const auto& [name, v3] : vectors) gl_.Uniform3f(ground_->uniform(name), v3.x, v3.y, v3.z);
    gl_.Uniform1f(ground_->uniform("spacing"), spacing);
    gl_.Uniform1f(ground_->uniform("reach"), static_cast<float>(reach));
    pass.draw_squares(1);
  }
}

}  // namespace feder::view
