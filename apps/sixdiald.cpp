// sixdiald: the measurement service. See service/daemon.h.
#include <iostream>

#include "cli/manual.h"
#include "service/daemon.h"

int main(int argc, char** argv) {
  return sixdial::service::run_daemon(
      argc, argv, std::cout, std::cerr, [](const CLI::App& app) {
        constexpr int kSystemAdministration = 8;  // section of the manual
        return sixdial::cli::manual_page(app, kSystemAdministration);
      });
}
