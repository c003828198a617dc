#include "end_state.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rivals {
namespace {

struct Box {
  Vec center, axis[3];
  float half[3] = {};
  float radius = 0;  // of the sphere around it
  bool dynamic = false;
};

// Half the extent of a box along a unit direction.
float extent(const Box& b, Vec n) {
  float sum = 0;
  for (int k = 0; k < 3; ++k) sum += b.half[k] * std::fabs(dot(b.axis[k], n));
  return sum;
}

// Penetration of two boxes: the smallest overlap of their shadows on the 15 axes of Gottschalk et al., "OBBTree",
// SIGGRAPH 1996; 0 when they are apart.
float penetration(const Box& a, const Box& b) {
  const Vec d = b.center - a.center;
  float least = std::numeric_limits<float>::infinity();
  const auto shadow = [&](Vec n) {
    least = std::min(least, extent(a, n) + extent(b, n) - std::fabs(dot(d, n)));
    return least > 0;
  };
  for (int k = 0; k < 3; ++k)
    if (!shadow(a.axis[k]) || !shadow(b.axis[k])) return 0;
  for (const Vec u : a.axis)
    for (const Vec v : b.axis) {
      const Vec n = cross(u, v);
      const float norm = length(n);
      if (norm > 1e-3f && !shadow(1 / norm * n)) return 0;  // of parallel edges the faces know more
    }
  return least;
}

std::vector<Box> boxes_of(const Scene& scene, const std::vector<BodyState>& states) {
  std::vector<Box> boxes;
  for (std::size_t i = 0; i < states.size(); ++i) {
    const Body& body = scene.bodies[i];
    const Shape& shape = scene.shapes[body.shape];
    if (shape.kind != ShapeKind::box || body.shape_count != 1 || !body.collides) continue;
    const Rotation q = states[i].rotation;
    Box box{.center = states[i].position,
            .axis = {rotate(q, {1, 0, 0}), rotate(q, {0, 1, 0}), rotate(q, {0, 0, 1})},
            .half = {shape.half.x, shape.half.y, shape.half.z},
            .radius = length(shape.half),
            .dynamic = body.motion == Motion::dynamic};
    boxes.push_back(box);
  }
  return boxes;
}

// Sweep along x over the spheres around the boxes.
double largest_overlap(std::vector<Box> boxes) {
  const auto left = [](const Box& b) { return b.center.x - b.radius; };
  std::sort(boxes.begin(), boxes.end(), [&](const Box& a, const Box& b) { return left(a) < left(b); });
  float largest = 0;
  std::vector<const Box*> open;
  for (const Box& b : boxes) {
    std::erase_if(open, [&](const Box* a) { return a->center.x + a->radius < left(b); });
    for (const Box* a : open)
      if ((a->dynamic || b.dynamic) && length(a->center - b.center) < a->radius + b.radius)
        largest = std::max(largest, penetration(*a, b));
    open.push_back(&b);
  }
  return largest;
}

double largest_joint_error(const Scene& scene, const std::vector<BodyState>& states) {
  float largest = 0;
  // every body starts without rotation: local anchors are differences
  const auto anchor = [&](std::uint32_t body, Vec at) {
    return states[body].position + rotate(states[body].rotation, at - scene.bodies[body].position);
  };
  for (const Joint& j : scene.joints)
    largest = std::max(largest, length(anchor(j.a, j.anchor) - anchor(j.b, j.anchor)));
  return largest;
}

float size_of(const Shape& s) {
  if (s.kind == ShapeKind::box) return 2 * std::min({s.half.x, s.half.y, s.half.z});
  return 2 * (s.kind == ShapeKind::hull ? length(s.points[0]) : s.radius);
}

}  // namespace

EndState end_state(const Scene& scene, const Engine& engine) {
  EndState end;
  std::vector<BodyState> states;
  float lowest = 0;
  end.top = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    states.push_back(engine.state(i));
    lowest = std::min(lowest, scene.bodies[i].position.y);
  }
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (scene.bodies[i].motion != Motion::dynamic) continue;
    const BodyState& s = states[i];
    const Vec d = s.position - scene.bodies[i].position;
    end.finite &= std::isfinite(dot(d, d) + dot(s.velocity, s.velocity));
    ++end.dynamic;
    end.asleep += s.asleep;
    end.moved += length(d) > size_of(scene.shapes[scene.bodies[i].shape]) / 2;
    end.lost += s.position.y < lowest - 20;
    end.sink -= d.y;
    end.speed += length(s.velocity);
    end.top = std::max<double>(end.top, s.position.y);
    end.drift = std::max<double>(end.drift, std::hypot(d.x, d.z));
  }
  end.sink /= std::max(end.dynamic, 1);
  end.speed /= std::max(end.dynamic, 1);
  if (!end.finite) {  // no zero must stand for what cannot be measured
    for (double* figure : {&end.sink, &end.top, &end.drift, &end.speed, &end.overlap, &end.joint_error})
      *figure = std::numeric_limits<double>::quiet_NaN();
    return end;
  }
  end.overlap = largest_overlap(boxes_of(scene, states));
  end.joint_error = largest_joint_error(scene, states);
  return end;
}

}  // namespace rivals
