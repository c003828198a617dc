// An orbit camera: looks at `target` from `distance`. Angles in radians. Matrices are column-major, as OpenGL takes
// them.
#pragma once
#include "view/frame.h"

namespace feder::view {

struct Matrix4 {
  float m[16];
};
Matrix4 operator*(const Matrix4& a, const Matrix4& b);

struct Camera {
  float target[3] = {0, 0, 0};  // m
  float distance = 10;          // m
  float yaw = 0.6f;             // 0 looks along -z, positive turns the eye towards +x
  float pitch = 0.35f;          // above the horizon
  float fov = 0.7f;             // vertical

  // Turns towards the subject and stands back just far enough for an image of that aspect (width / height). Keeps
  // yaw and pitch.
  void fit(const Bounds& subject, float aspect);
  // The same for subject_of(frame); a 2D frame is seen from the front.
  void fit(const Frame& frame, float aspect);
  void look_at(const float eye[3], const float at[3]);

  void eye(float out[3]) const;
  void axes(float right[3], float up[3], float back[3]) const;
  Matrix4 view() const;
  Matrix4 projection(float aspect) const;  // near and far follow the distance
  // The ray through a pixel (0, 0 is the top left corner): origin and unit direction, for picking.
  void ray(float x, float y, int width, int height, float origin[3], float direction[3]) const;
  // Pixel of a world point; false when behind the camera.
  bool project(const float point[3], int width, int height, float& x, float& y) const;
};

inline constexpr float kPlanarFov = 0.35f;  // nearly without perspective

// What a picture of the frame is about: the moving things, without those that have flown off, and what is fixed near
// them. Infinite planes do not count.
Bounds subject_of(const Frame& frame);

}  // namespace feder::view
