// Hangs one sheet in one engine, and prints what a frame of it costs and how much it is stretched, as one line of JSON.
//   sheet_ENGINE VERTICES SECONDS TIMED SUBSTEPS ITERATIONS SELF
// VERTICES along a side; TIMED: the last seconds, of which cost and strain are; SUBSTEPS, ITERATIONS 0: the engine's
// own. Strain is that of the threads: neighbours along rows and columns.
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "sheet.h"

namespace rivals {
namespace {

// Of all threads, s.
double processor_time() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](timeval t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

// Strains of all threads, the largest last.
std::vector<double> strains(const SheetScene& scene, const std::vector<Vec>& x) {
  const int n = scene.side_vertices;
  const double rest = static_cast<double>(scene.side) / (n - 1);
  std::vector<double> out;
  const auto add = [&](int i, int j) {
    const Vec d = x[static_cast<std::size_t>(j)] - x[static_cast<std::size_t>(i)];
    out.push_back(static_cast<double>(length(d)) / rest - 1);
  };
  for (int row = 0; row < n; ++row)
    for (int column = 0; column < n; ++column) {
      const int i = row * n + column;
      if (column + 1 < n) add(i, i + 1);
      if (row + 1 < n) add(i, i + n);
    }
  // not a number counts as the largest
  std::sort(out.begin(), out.end(), [](double a, double b) { return a < b || (std::isnan(b) && !std::isnan(a)); });
  return out;
}

int run(const SheetScene& scene, const SheetSettings& settings, double seconds, double timed) {
  const auto engine = make_sheet(scene, settings);
  const int frames = static_cast<int>(std::lround(seconds / static_cast<double>(scene.dt)));
  const int counted = std::max(1, static_cast<int>(std::lround(timed / static_cast<double>(scene.dt))));
  std::vector<Vec> x, last;
  double spent = 0, worst = 0, median = 0, speed = 0, sweeps = 0;
  for (int k = 0; k < frames; ++k) {
    const double before = processor_time();
    engine->frame();
    const double cost = processor_time() - before;
    if (k < frames - counted) continue;
    spent += cost, sweeps += engine->rows().sweeps;
    engine->positions(x);
    const std::vector<double> found = strains(scene, x);
    worst = std::isnan(found.back()) ? found.back() : std::max(worst, found.back());
    median = std::max(median, found[found.size() / 2]);
    for (std::size_t i = 0; i < x.size() && !last.empty(); ++i)
      speed = std::max(speed, static_cast<double>(length(x[i] - last[i]) / scene.dt));
    last = x;
  }
  const Rows rows = engine->rows();
  const double ms = 1e3 * spent / counted;
  std::printf(
      "{\"engine\": \"%s\", \"side_vertices\": %d, \"links\": %ld, \"bends\": %ld, \"sweeps\": %.6g, "
      "\"frame_ms\": %.6g, \"row_ns\": %.6g, \"worst\": %.6g, \"median\": %.6g, \"speed_m_s\": %.6g}\n",
      kSheetEngineName, scene.side_vertices, rows.links, rows.bends, sweeps / counted, ms,
      1e6 * ms / (static_cast<double>(rows.links + rows.bends) * sweeps / counted), worst, median, speed);
  return 0;
}

}  // namespace
}  // namespace rivals

int main(int count, char** words) {
  rivals::SheetScene scene;
  rivals::SheetSettings settings;
  double seconds = 0, timed = 0;
  if (count == 7) {
    scene.side_vertices = std::atoi(words[1]);
    seconds = std::atof(words[2]), timed = std::atof(words[3]);
    settings.substeps = std::atoi(words[4]), settings.iterations = std::atoi(words[5]);
    settings.self = std::atoi(words[6]) != 0;
  }
  if (scene.side_vertices < 3 || !(timed > 0 && timed <= seconds) || settings.substeps < 0 || settings.iterations < 0) {
    std::fprintf(stderr, "usage: sheet_%s VERTICES SECONDS TIMED SUBSTEPS ITERATIONS SELF\n", rivals::kSheetEngineName);
    return 2;
  }
  return rivals::run(scene, settings, seconds, timed);
}
