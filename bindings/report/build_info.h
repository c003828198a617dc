// What this program was built from, and what of it runs on this machine.
#pragma once
#include <string>

namespace feder::report {

const char* build_commit();    // short; empty: not built in a checkout. Alone in commit.cpp: each commit compiles it
std::string build_compiler();  // "gcc 12.2"
std::string build_flags();
std::string simd_path();  // of the kernels that are there twice: "avx2" or "plain"

}  // namespace feder::report
