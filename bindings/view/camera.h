// An orbit camera: looks at `target` from `distance`. Angles in radians. Matrices are column-major, as OpenGL takes
// them.
#pragma once
#include "view/frame.h"

namespace feder::view {

struct Matrix4 {
  float m[16];
};
Matrix4 operator*(const Matrix4& a, const Matrix4& b);

struct CameraAxes {
  Float3 right, up, back;
};

struct Camera {
  Float3 target;        // m
  float distance = 10;  // m
  float yaw = 0.6f;     // 0 looks along -z, positive turns the eye towards +x
  float pitch = 0.35f;  // above the horizon
  float fov = 0.7f;     // vertical

  // Turns towards the subject and stands back just far enough for an image of that aspect (width / height). Keeps
  // yaw and pitch.
  void fit(const Bounds& subject, float aspect);
  // The same for subject_of(frame); a 2D frame is seen from the front.
  void fit(const Frame& frame, float aspect);
  void look_at(Float3 eye, Float3 at);

  Float3 eye() const { return target + distance * axes().back; }
  CameraAxes axes() const;
  Matrix4 view() const;
  Matrix4 projection(float aspect) const;  // near and far follow the distance
  // The ray through a pixel (0, 0 is the top left corner): origin and unit direction, for picking.
  std::pair<Float3, Float3> ray(float x, float y, int width, int height) const;
  // Pixel of a world point; false when behind the camera.
  bool project(Float3 point, int width, int height, float& x, float& y) const;
};

inline constexpr float kPlanarFov = 0.35f;  // nearly without perspective

// What a picture of the frame is about: the moving things, without those that have flown off, and what is fixed near
// them. Infinite planes do not count.
Bounds subject_of(const Frame& frame);

}  // namespace feder::view
