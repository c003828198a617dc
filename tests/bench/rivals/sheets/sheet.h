// A sheet of cloth as every engine can build it, and an engine that moves it. SI units, y up.
#pragma once
#include <memory>
#include <vector>

#include "../scene.h"

namespace rivals {

// Square, in the plane z = 0 at the start, hung at its two upper corners; vertex (column, row) is row * side_vertices +
// column, row 0 at the top.
struct SheetScene {
  int side_vertices = 0;
  float side = 3;            // m
  float area_density = .2f;  // kg/m^2
  float gravity = -9.81f;    // m/s^2, along y
  float dt = 1.f / 60;       // s, of a frame

  Vec corner(int column, int row) const {
    const float cell = side / static_cast<float>(side_vertices - 1);
    return {static_cast<float>(column) * cell, -static_cast<float>(row) * cell, 0};
  }
  float mass() const { return area_density * side * side; }
};

// What a run may ask of an engine; 0: its default.
struct SheetSettings {
  int substeps = 0;    // of a frame, which the engine makes one after another
  int iterations = 0;  // of its solver in each
  bool self = true;    // collides with itself, in engines whose sheets do so by default
};

struct Rows {
  long links = 0, bends = 0;
  double sweeps = 0;  // times that each is solved in a frame, as the engine stands now
};

class SheetEngine {
 public:
  virtual ~SheetEngine() = default;
  virtual void frame() = 0;  // scene.dt
  virtual Rows rows() const = 0;
  virtual void positions(std::vector<Vec>& out) const = 0;
};

extern const char* const kSheetEngineName;
std::unique_ptr<SheetEngine> make_sheet(const SheetScene& scene, const SheetSettings& settings);

}  // namespace rivals
