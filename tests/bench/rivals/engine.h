// An engine that runs scenes. One file per engine, each linked into a program of its own with main.cpp: settings are
// the engine's defaults, except what a scene says.
#pragma once
#include <memory>

#include "scene.h"

namespace rivals {

struct BodyState {
  Vec position = {};  // of the body's frame, m
  Rotation rotation = {};
  Vec velocity = {};  // of the centre of mass, m/s
  bool asleep = false;
};

class Engine {
 public:
  virtual ~Engine() = default;
  virtual void build(const Scene& scene) = 0;  // once: adds bodies and joints to the empty world
  virtual void step() = 0;                     // scene.dt
  virtual BodyState state(std::size_t body) const = 0;
};

extern const char* const kEngineName;
extern const bool kEngineHasThreads;

// An empty world with room for the scene. Exits with a message when the engine cannot have that many threads.
std::unique_ptr<Engine> make_engine(const Scene& scene, int threads);

}  // namespace rivals
