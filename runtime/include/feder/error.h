// Errors. Scene mistakes: SceneError, thrown while things are made or edited and never inside a step; then nothing has
// changed (strong guarantee). Bindings turn it into a script error. Programming mistakes: FEDER_ASSERT.
#pragma once
#include <stdexcept>
#include <string>

namespace feder {

// The message says what was expected and what came, without file and line (the binding adds them).
class SceneError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace feder

// FEDER_ASSERT(condition): programming mistakes, never a scene's. On unless NDEBUG; prints file:line and aborts.
// kAsserts guards checks that take more than one expression (System::validate).
namespace feder {
[[noreturn]] void assert_failed(const char* condition, const char* file, int line);

#ifdef NDEBUG
inline constexpr bool kAsserts = false;
#else
inline constexpr bool kAsserts = true;
#endif
}  // namespace feder

#ifdef NDEBUG
#define FEDER_ASSERT(condition) ((void)sizeof(!(condition)))  // not evaluated, yet its names count as used
#else
#define FEDER_ASSERT(condition) ((condition) ? (void)0 : ::feder::assert_failed(#condition, __FILE__, __LINE__))
#endif
