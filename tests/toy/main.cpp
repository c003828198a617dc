// The feder program with wind socks.
#include "toy/parts.h"

int main(int argc, char* argv[]) {
  const feder::ToyBuild toy;
  return feder::cli::run_program(argc, argv, toy.build());
}
