// Studies of broad phases on boxes that were recorded in a world. Private to the module and to the program.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "broad/broad_phase.h"
#include "feder/study.h"

namespace feder {

struct BoxRecording {
  std::string of;  // whose boxes they are, for listings
  struct Frame {
    std::vector<Aabb> boxes;
    std::vector<BoxMotion> motion;
  };
  std::vector<Frame> frames;  // of one step after another; the number of boxes may change
};

// Problem "broad_phase" on those boxes; SceneError where fewer than two frames were recorded.
std::unique_ptr<StudyProblem> broad_phase_study(BoxRecording recording);

}  // namespace feder
