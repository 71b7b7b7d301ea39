#include "session/bundle.h"

#include <fmt/format.h>

#include <utility>

#include "session/columns.h"
#include "session/csv.h"
#include "session/live_channels.h"
#include "session/rig_file.h"
#include "session/rig_write.h"
#include "session/row_reader.h"
#include "session/sample_layout.h"

namespace sixdial::session {

Session parse_session(
    std::string_view csv_text, const std::string& csv_name, std::string_view rig_text,
    const std::string& rig_name, const ReadOptions& options) {
  Session session;
  session.name = options.name;
  session.rig = parse_rig(rig_text, rig_name);
  session.rig_text = self_contained(session.rig, rig_text);
  session.rig = as_instrument(std::move(session.rig));
  CsvTable table = read_csv(csv_text, csv_name);
  while (!table.rows.empty() && is_blank(table.rows.back())) {
    table.end = table.line_end + std::string(table.rows.back().text) + table.end;
    table.rows.pop_back();
  }
  session.csv_header = std::string(table.header.text);
  session.line_end = table.line_end;
  session.csv_end = table.end;

  std::vector<Mistake> mistakes;
  std::size_t total = 0;
  const SampleLayout layout = layout_of(session.rig);
  std::vector<HeaderColumn> columns = read_header(table.header, layout, mistakes);
  if (!mistakes.empty()) {
    total = mistakes.size();
    throw DataError(csv_name, std::move(mistakes), total);
  }
  const ReadRow read_row = row_reader(session.rig, layout, std::move(columns));
  session.samples.reserve(table.rows.size());
  for (const CsvRow& row : table.rows) {
    auto sample = read_row(row);
    if (sample) {
      session.samples.push_back(std::move(*sample));
    } else if (options.skip_bad_rows) {
      session.rejected.push_back(
          {row.line, std::string(row.text), to_string(csv_name, sample.error())});
    } else {
      ++total;
      if (mistakes.size() < DataError::kMostShown) mistakes.push_back(sample.error());
    }
  }
  if (total > 0) throw DataError(csv_name, std::move(mistakes), total);
  return session;
}

Session read_bundle(
    const std::filesystem::path& session_csv, const std::filesystem::path& rig_toml,
    const ReadOptions& options) {
  ReadOptions named = options;
  if (named.name.empty()) {
    // The folder says more than "session.csv" does.
    const auto folder = std::filesystem::absolute(session_csv).lexically_normal().parent_path();
    named.name = folder.filename().string();
  }
  const std::string rig_text = read_file(rig_toml.string());
  const std::string csv_text = read_file(session_csv.string());
  return parse_session(csv_text, session_csv.string(), rig_text, rig_toml.string(), named);
}

Session read_bundle(const std::filesystem::path& bundle, const ReadOptions& options) {
  const bool folder = std::filesystem::is_directory(bundle);
  if (!folder && !std::filesystem::exists(bundle)) {
    throw DataError(
        bundle.string(), Mistake{
                             0, 0, "", "there is no such folder or file",
                             "name a folder with session.csv and rig.toml, or a CSV file with "
                             "rig.toml beside it"});
  }
  const auto csv = folder ? bundle / "session.csv" : bundle;
  const auto rig = folder ? bundle / "rig.toml" : bundle.parent_path() / "rig.toml";
  return read_bundle(csv, rig, options);
}

}  // namespace sixdial::session
