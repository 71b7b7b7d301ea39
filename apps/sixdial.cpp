// sixdial: the command line. See cli/.
#include <iostream>

#include "cli/cli.h"

int main(int argc, char** argv) {
  sixdial::service::interrupt_on_signals();
  return sixdial::cli::run(argc, argv, std::cout, std::cerr);
}
