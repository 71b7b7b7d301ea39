// sixdial: the command line. See service/cli/.
#include <iostream>

#include "service/cli/cli.h"

int main(int argc, char** argv) {
  sixdial::service::interrupt_on_signals();
  return sixdial::service::cli::run(argc, argv, std::cout, std::cerr);
}
