// What became of a scene, measured the same way for every engine: from poses alone.
#pragma once
#include "engine.h"

namespace rivals {

struct EndState {
  bool finite = true;      // else the figures below the counts are NaN
  int dynamic = 0;         // bodies
  int asleep = 0;          // of them
  int moved = 0;           // left their place by more than half their size
  int lost = 0;            // more than 20 m below the lowest place at the start
  double sink = 0;         // mean drop, m
  double top = 0;          // highest origin of a body, m
  double drift = 0;        // largest sideways displacement, m
  double speed = 0;        // mean, m/s
  double overlap = 0;      // largest of two boxes, m
  double joint_error = 0;  // largest distance of a joint's anchors, m
};

EndState end_state(const Scene& scene, const Engine& engine);

}  // namespace rivals
