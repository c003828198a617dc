#include "cli/app.h"

int main(int argc, char* argv[]) { return feder::cli::run_program(argc, argv); }
