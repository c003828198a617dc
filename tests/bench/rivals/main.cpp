// Runs one scene in one engine, in a process of its own, and prints times, memory and end state as one line of JSON.
//   rival_ENGINE SCENE STEPS THREADS     STEPS 0: as many as the scene is run for usually
//   rival_ENGINE --list                  the scenes, a line each: name and steps
#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "end_state.h"

namespace rivals {
namespace {

// Step at which memory is read, or the last.
constexpr int kMemoryStep = 100;

// Of all threads, s.
double processor_time() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](timeval t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double wall_time() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Memory of the process that is in use, MB.
double resident() {
  long pages = 0, all = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(file, "%ld %ld", &all, &pages) != 2) pages = 0;
    std::fclose(file);
  }
  return static_cast<double>(pages) * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

int run(const SceneRow& row, int steps, int threads) {
  Scene scene;
  row.build(scene);
  const auto engine = make_engine(scene, threads);
  // what building the description has freed must not serve the engine
  malloc_trim(0);
  const double empty = resident();
  engine->build(scene);
  engine->step();  // the first makes arrays and trees: it is not counted
  double memory = resident() - empty;
  const double processor = processor_time(), wall = wall_time();
  for (int step = 2; step <= steps; ++step) {
    engine->step();
    if (step <= kMemoryStep) memory = resident() - empty;
  }
  const double counted = 1e-3 * std::max(steps - 1, 1);
  const double processor_ms = (processor_time() - processor) / counted, wall_ms = (wall_time() - wall) / counted;
  const EndState end = end_state(scene, *engine);
  std::printf(
      "{\"scene\": \"%s\", \"engine\": \"%s\", \"threads\": %d, \"steps\": %d, \"processor_ms\": %.6g, \"wall_ms\": "
      "%.6g, \"memory_mb\": %.4g, \"finite\": %s, \"bodies\": %d, \"joints\": %zu, \"asleep\": %d, \"moved\": %d, "
      "\"lost\": %d, \"sink_m\": %.6g, \"top_m\": %.6g, \"drift_m\": %.6g, \"speed_m_s\": %.6g, \"overlap_m\": %.6g, "
      "\"joint_error_m\": %.6g}\n",
      row.name, kEngineName, threads, steps, processor_ms, wall_ms, memory, end.finite ? "true" : "false", end.dynamic,
      scene.joints.size(), end.asleep, end.moved, end.lost, end.sink, end.top, end.drift, end.speed, end.overlap,
      end.joint_error);
  return 0;
}

}  // namespace
}  // namespace rivals

int main(int count, char** words) {
  using namespace rivals;
  if (count == 2 && std::string(words[1]) == "--list") {
    for (const SceneRow& row : scene_rows()) std::printf("%s %d\n", row.name, row.steps);
    return 0;
  }
  const SceneRow* row = count == 4 ? find_scene(words[1]) : nullptr;
  const int steps = row ? std::atoi(words[2]) : -1, threads = row ? std::atoi(words[3]) : 0;
  if (!row || steps < 0 || threads < 1) {
    std::fprintf(stderr, "usage: rival_%s SCENE STEPS THREADS, or --list\n", kEngineName);
    return 2;
  }
  if (threads > 1 && !kEngineHasThreads) {
    std::fprintf(stderr, "%s is built for one thread\n", kEngineName);
    return 2;
  }
  return run(*row, steps ? steps : row->steps, threads);
}
