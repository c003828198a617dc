// What the watchdog (step/watch.h) wants to know of forces on the points of a soft thing.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "feder/plan.h"
#include "forces/forces.h"

namespace feder {

// Calls f(entry) for the generators that act on that object.
template <class F>
void each_acting(const Forces* forces, ObjectId object, TagMask tags, F&& f) {
  if (!forces) return;
  for (const ForceEntry& entry : forces->list)
    if (acts_on(entry, object, tags)) f(entry);
}

// Of the forces on a point, N: all of them, and weight and scripts alone.
struct PointForces {
  double all = 0, own = 0;
};

// Upper bound of the work on n points in a step, J: force times path. For a generator with a potential it is the loss
// of potential instead: where one is too stiff for the step, force times path would explain any energy. each_force(f)
// calls f(entry); point(i) is a MassPoint at the end of the step, began(i) its position at the start, the same where it
// is held, m; forces(i) are PointForces.
template <class Each, class Point, class Began, class PointForce>
double work_bound(std::uint32_t n, const StepContext& c, Each&& each_force, Point&& point, Began&& began,
                  PointForce&& forces) {
  const auto path = [&](std::uint32_t i) { return static_cast<double>(length(Vec3(point(i).position - began(i)))); };
  double all = 0, own = 0, fall = 0, push = 0;
  for (std::uint32_t i = 0; i < n; ++i) {
    const PointForces f = forces(i);
    const double far = path(i);
    all += f.all * far, own += f.own * far;
  }
  bool held = false, area = false;
  each_force([&](const ForceEntry& f) {
    area = area || f.force->on_area();
    double potential[2] = {0, 0}, most = 0;
    for (std::uint32_t i = 0; i < n; ++i) {
      MassPoint p = point(i);
      Vec3 before = Vec3::Zero(), after = Vec3::Zero();
      potential[1] += f.force->potential(&p, 1);
      f.force->add(&p, 1, c.time + static_cast<double>(c.dt), &after);
      p.position = began(i);
      potential[0] += f.force->potential(&p, 1);
      f.force->add(&p, 1, c.time, &before);
      most += static_cast<double>(std::max(length(before), length(after))) * path(i);
    }
    const bool conserves = potential[0] != 0 || potential[1] != 0;
    held = held || conserves;
    if (conserves)
      fall += std::fmax(potential[0] - potential[1], 0.0);
    else
      push += most;
  });
  return held && !area ? std::fmin(all, fall + push + own) : all;
}

}  // namespace feder
