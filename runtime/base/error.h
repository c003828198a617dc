// Scene mistakes: thrown while a scene is built, never inside a step; bindings turn them into script errors.
#pragma once
#include <stdexcept>
#include <string>

namespace feder {

// The message says what was expected and what came, without a place (the binding adds file:line).
class SceneError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace feder
