// Two kinds of mistakes. A scene's: SceneError, thrown while things are made or edited and never inside a step; what
// was asked for has not been done then, and nothing else has changed. Bindings turn it into a script error.
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

// FEDER_ASSERT(condition): own mistakes, never a scene's. On unless NDEBUG; prints file:line and aborts.
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
