// The test framework, version 2 (Debian 12) or 3, under one include: `Approx` and `Catch::Contains` work with both.
#pragma once
#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
using Catch::Approx;
namespace Catch {
inline auto Contains(const std::string& part) { return Matchers::ContainsSubstring(part); }
}  // namespace Catch
#else
#include <catch2/catch.hpp>
using Catch::Detail::Approx;
#endif
