// FEDER_ASSERT(condition): own mistakes. On unless NDEBUG; prints file:line and aborts.
#pragma once

namespace feder {
[[noreturn]] void assert_failed(const char* condition, const char* file, int line);
}

#ifdef NDEBUG
#define FEDER_ASSERT(condition) ((void)0)
#else
#define FEDER_ASSERT(condition) ((condition) ? (void)0 : ::feder::assert_failed(#condition, __FILE__, __LINE__))
#endif
