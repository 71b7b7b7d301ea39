// Writes the sample session's report into a folder, to look at it: report.html, report.json,
// *.csv.
#include <filesystem>
#include <fstream>
#include <iostream>

#include "report/csv_report.h"
#include "report/html_report.h"
#include "report/json_report.h"
#include "sample_session.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: write_sample_report FOLDER\n";
    return 2;
  }
  const std::filesystem::path folder{argv[1]};
  std::filesystem::create_directories(folder);
  const sixdial::report::ReportData data = sixdial::report::sample_session();
  const auto write = [&](const std::string& name, const std::string& text) {
    std::ofstream file{folder / name, std::ios::binary};
    file << text;
    if (!file.flush()) throw std::runtime_error("cannot write " + (folder / name).string());
  };
  write("report.html", sixdial::report::html_report(data));
  write("report.json", sixdial::report::json_report(data));
  for (const auto& [name, text] : sixdial::report::csv_report(data)) write(name, text);
}
