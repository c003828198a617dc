// Boxes of a scene's colliders, recorded while it runs, for studies of broad phases.
#include <algorithm>

#include "cli/command.h"
#include "cli/session.h"
#include "cli/study_parts.h"
#include "feder/lua.h"
#include "feder/query.h"
#include "study/broad_phase.h"

namespace feder::cli {
namespace {

constexpr int kRecordedSteps = 256;  // 32 of a study, by strides of 1 to 8

}  // namespace

std::unique_ptr<StudyProblem> open_boxes(const std::string& file, const Options& options) {
  BoxRecording recording;
  recording.of = file;
  std::size_t most = 0;
  try {
    lua::Script script(silent_host_options(options));
    script.load_file(file);
    script.build();
    for (int step = 0; step <= kRecordedSteps; ++step) {
      script.step();
      for (const lua::HandlerError& e : script.handler_errors()) throw Failure(kLoadError, error_text(e));
      Collide* collide = script.world()->find<Collide>();
      if (!collide) break;
      const std::span<const Aabb> boxes = collide->boxes();
      const std::span<const BoxMotion> motion = collide->box_motion();
      const std::size_t count = std::min(boxes.size(), motion.size());  // without what came after the search
      most = std::max(most, count);
      recording.frames.push_back({{boxes.begin(), boxes.begin() + static_cast<std::ptrdiff_t>(count)},
                                  {motion.begin(), motion.begin() + static_cast<std::ptrdiff_t>(count)}});
    }
  } catch (...) {
    fail_by_script(kLoadError);
  }
  if (most < 2)
    throw Failure(kUsage, "feder study: --boxes: {} has {} colliders; a broad phase needs two at least", file, most);
  return broad_phase_study(std::move(recording));
}

}  // namespace feder::cli
