// sixdiald: the measurement service. See service/daemon.h.
#include <iostream>

#include "service/daemon.h"

int main(int argc, char** argv) {
  return sixdial::service::run_daemon(argc, argv, std::cout, std::cerr);
}
