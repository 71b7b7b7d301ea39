// sixdial doctor, rig scan: ports, rights, socket, database, disk, the rig's devices; for each
// line what to do. Works without a service.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "acquisition/connection.h"
#include "acquisition/rig_scan.h"
#include "cli/cli.h"
#include "cli/health.h"
#include "service/daemon.h"
#include "service/socket/server.h"
#include "session/reason.h"
#include "session/rig_file.h"

namespace sixdial::cli {
namespace {

struct DoctorOptions {
  std::string rig_file;
  std::string database{};  // empty: the running service's, else the usual
  std::string by_id = "/dev/serial/by-id";
  std::vector<std::string> ports, boxes;
  bool no_search = false;
};

const char* word_of(Health health) {
  switch (health) {
    case Health::kOk:
      return "ok";
    case Health::kWarning:
      return "warning";
    case Health::kFailed:
      break;
  }
  return "failed";
}

std::string reading_text(const acquisition::Reading& reading) {
  if (reading.value_mm) return fmt::format("{:.3f} mm", *reading.value_mm);
  return reading.reason.empty() ? "-" : reading.reason;
}

Json reading_json(const acquisition::Reading& reading) {
  return {
      {"value_mm", reading.value_mm ? Json(*reading.value_mm) : Json(nullptr)},
      {"quality", session::to_string(reading.quality)},
      {"reason", reading.reason},
      {"time_utc", session::to_iso8601(reading.time_utc)}};
}

std::string line(const char* state, const std::string& what, const std::string& fix) {
  std::string text = fmt::format("{:<8} {}\n", state, what);
  if (!fix.empty()) text += fmt::format("{:<8} -> {}\n", "", fix);
  return text;
}

Json place_json(const acquisition::ScannedPlace& place) {
  Json dials = Json::array();
  for (const acquisition::FoundDial& dial : place.dials) {
    Json row = reading_json(dial.reading);
    row["connection"] = dial.connection;
    row["answer"] = dial.answer;
    dials.push_back(std::move(row));
  }
  return {
      {"place", place.name}, {"dials", dials}, {"trouble", place.trouble}, {"fix", place.fix}};
}

std::string place_text(const acquisition::ScannedPlace& place) {
  std::string text;
  for (const acquisition::FoundDial& dial : place.dials) {
    text += line(
        "dial", fmt::format("{:<12} {}", reading_text(dial.reading), dial.connection),
        dial.reading.quality == session::Quality::kBad
            ? acquisition::advice_for(dial.reading.reason)
            : "");
  }
  if (place.dials.empty()) {
    text += line("nothing", fmt::format("{}: {}", place.name, place.trouble), place.fix);
  }
  return text;
}

/// The ports that the rig's dials do not hold already, and those it names that are silent.
std::vector<std::string> places_to_try(const DoctorOptions& options) {
  if (!options.ports.empty()) return options.ports;
  std::vector<std::string> places;
  for (const acquisition::PortName& port : acquisition::serial_ports(options.by_id)) {
    places.push_back(port.name);
  }
  return places;
}

void name_boxes_of(const geometry::Rig& rig, std::vector<std::string>& boxes) {
  for (const geometry::Dial& dial : rig.dials) {
    const auto connection = acquisition::parse_dial_connection(dial.connection);
    if (!connection) continue;
    const auto* modbus = std::get_if<acquisition::ModbusConnection>(&*connection);
    if (modbus == nullptr ||
        !std::holds_alternative<acquisition::ModbusTcpEndpoint>(modbus->endpoint)) {
      continue;
    }
    const std::string name = name_of(modbus->endpoint);
    if (std::ranges::find(boxes, name) == boxes.end()) boxes.push_back(name);
  }
}

/// A file that says nothing of how well it knows its own geometry is read as exact.
std::string silence_of(const geometry::Rig& rig) {
  return rig.dials.empty() || !rig.on_cuboid() || rig.states_deviations()
             ? ""
             : "the rig file does not say how well the places of the dials are "
               "known; real ones are known to 0.03 to 0.1 mm";
}

struct RigOutcome {
  Json json;
  std::string text;
  bool good = true;
};

/// Of a line of the rig file whose port is not there: which ports are.
std::string ports_instead(const acquisition::CheckedDial& dial, const std::string& by_id) {
  const bool serial =
      dial.connection.starts_with("serial:") || dial.connection.starts_with("modbus-rtu:");
  if (dial.reading.reason != session::reason::kDisconnected || !serial) return "";
  std::vector<std::string> names;
  for (const acquisition::PortName& port : acquisition::serial_ports(by_id)) {
    std::error_code ignored;
    if (std::filesystem::exists(port.device, ignored)) names.push_back(port.name);
  }
  if (names.empty()) {
    return "; no serial port is there at all: plug the adapter in (dmesg tells whether it is "
           "seen)";
  }
  return fmt::format("; the ports that are there: {}", fmt::join(names, ", "));
}

RigOutcome checked_rig(
    const geometry::Rig& rig, const std::vector<acquisition::ScannedPlace>& found,
    acquisition::Clock& clock, const std::string& by_id) {
  const acquisition::CheckedRig checked = acquisition::check_rig(rig, found, clock, {});
  RigOutcome outcome{.json = Json::object(), .text = {}, .good = checked.good()};
  outcome.json = {{"name", rig.name},           {"good", outcome.good},
                  {"trouble", checked.trouble}, {"note", silence_of(rig)},
                  {"dials", Json::array()},     {"robot", nullptr}};
  if (!checked.trouble.empty()) {
    outcome.text +=
        line("failed", checked.trouble, "correct the connection strings of the rig file");
    return outcome;
  }
  for (const acquisition::CheckedDial& dial : checked.dials) {
    Json row = reading_json(dial.reading);
    row["dial"] = dial.id;
    row["connection"] = dial.connection;
    row["good"] = dial.good;
    row["trouble"] = dial.trouble;
    const std::string fix = dial.fix + (dial.good ? "" : ports_instead(dial, by_id));
    row["fix"] = fix;
    outcome.json["dials"].push_back(std::move(row));
    outcome.text += line(
        dial.good ? "ok" : "failed",
        fmt::format(
            "dial {}: {}  {}", dial.id, dial.good ? reading_text(dial.reading) : dial.trouble,
            dial.connection),
        fix);
  }
  if (checked.robot) {
    outcome.json["robot"] = {
        {"theta_rad", std::vector(checked.robot->q.begin(), checked.robot->q.end())},
        {"temperature_c",
         checked.robot->temperature_c ? Json(*checked.robot->temperature_c) : Json(nullptr)}};
  }
  outcome.json["robot_trouble"] = checked.robot_trouble;
  outcome.json["robot_fix"] = checked.robot_fix;
  if (!checked.robot_trouble.empty()) {
    outcome.text += line("failed", "robot: " + checked.robot_trouble, checked.robot_fix);
  } else if (checked.robot) {
    outcome.text += line(
        "ok", fmt::format("robot: theta {:.6f} rad", fmt::join(checked.robot->q, ", ")), "");
  } else {
    outcome.text += line("ok", "robot: moved by hand", "");
  }
  if (const std::string silence = silence_of(rig); !silence.empty()) {
    outcome.text += line(
        "note", silence,
        "measure how well, and write position_sd_mm and axis_sd_deg (doc/manual/mounting.md)");
  }
  return outcome;
}

service::ExitCode scan(Cli& cli, const DoctorOptions& options) {
  acquisition::SystemClock clock;
  std::optional<geometry::Rig> rig;
  std::vector<std::string> boxes = options.boxes;
  if (!options.rig_file.empty()) {
    rig = session::read_rig_file(options.rig_file);
    name_boxes_of(*rig, boxes);
  }
  std::vector<acquisition::ScannedPlace> found;
  if (!options.no_search) {
    for (const std::string& name : places_to_try(options)) {
      cli.console.note(fmt::format("asking on {} ...", name));
      found.push_back(acquisition::scan_serial(name, clock, {}));
    }
    for (const std::string& name : boxes) {
      found.push_back(acquisition::scan_gauge_box(name, clock, {}));
    }
  }
  Json places = Json::array();
  std::string text;
  bool anything = false;
  for (const acquisition::ScannedPlace& place : found) {
    places.push_back(place_json(place));
    text += place_text(place);
    anything = anything || !place.dials.empty();
  }
  if (found.empty() && !options.no_search) {
    text += line(
        "nothing", "no serial port is there, and no gauge box is named",
        "plug the adapters in, or name what to ask: --port, --modbus-tcp, --rig");
  }
  Json document{{"found", places}, {"rig", nullptr}};
  bool good = anything;
  if (rig) {
    RigOutcome outcome = checked_rig(*rig, found, clock, options.by_id);
    document["rig"] = std::move(outcome.json);
    text += fmt::format("rig file {}:\n{}", options.rig_file, outcome.text);
    good = outcome.good;
  }
  cli.console.print("rig.scan", document, text);
  return good ? service::ExitCode::kOk : service::ExitCode::kDevice;
}

/// Of the service that answers; where none does, where one of this user would have it.
std::filesystem::path database_of(Cli& cli, const DoctorOptions& options) {
  if (!options.database.empty()) return options.database;
  try {
    return cli.call("hello").at("database").get<std::string>();
  } catch (const std::exception&) {  // check_socket tells why
    return service::default_database_path();
  }
}

service::ExitCode examine(Cli& cli, const DoctorOptions& options) {
  std::vector<Check> checks = check_ports(options.by_id);
  checks.push_back(check_socket(
      cli.socket_path.empty() ? service::default_socket_path()
                              : std::filesystem::path(cli.socket_path)));
  const std::filesystem::path database = database_of(cli, options);
  checks.push_back(check_database(database));
  checks.push_back(check_disk(database));
  checks.push_back(check_known_answer());
  Json rows = Json::array();
  std::string text;
  service::ExitCode code = service::ExitCode::kOk;
  for (const Check& check : checks) {
    rows.push_back(
        {{"check", check.name},
         {"state", word_of(check.health)},
         {"what", check.what},
         {"fix", check.fix}});
    text +=
        line(word_of(check.health), fmt::format("{}: {}", check.name, check.what), check.fix);
    if (code == service::ExitCode::kOk) code = check.exit_code;
  }
  Json document{{"checks", rows}, {"rig", nullptr}};
  if (!options.rig_file.empty()) {
    acquisition::SystemClock clock;
    RigOutcome outcome =
        checked_rig(session::read_rig_file(options.rig_file), {}, clock, options.by_id);
    document["rig"] = std::move(outcome.json);
    text += fmt::format("rig file {}:\n{}", options.rig_file, outcome.text);
    if (!outcome.good && code == service::ExitCode::kOk) code = service::ExitCode::kDevice;
  }
  document["healthy"] = code == service::ExitCode::kOk;
  cli.console.print("doctor", document, text);
  return code;
}

}  // namespace

void add_doctor_commands(CLI::App& app, Cli& cli) {
  const auto options = std::make_shared<DoctorOptions>();
  CLI::App* doctor = app.add_subcommand(
      "doctor",
      "Looks at ports, rights, socket, database and disk, solves a known answer, and says for "
      "each what to do.");
  doctor->add_option("--rig", options->rig_file, "rig.toml: its dials and robot, too");
  doctor->add_option(
      "--db", options->database,
      "a database; default: the running service's, else where it would be made");
  doctor->add_option("--by-id", options->by_id, "folder of the ports' stable names")
      ->capture_default_str();
  doctor->callback(
      [&cli, options] { cli.action = [&cli, options] { return examine(cli, *options); }; });
  CLI::App* rig = app.get_subcommand("rig");  // `rig draw` is there
  CLI::App* scanning = rig->add_subcommand(
      "scan",
      "Finds ports and dials, shows their values, and checks a rig file against what answers.");
  scanning->add_option("--rig", options->rig_file, "rig.toml to check");
  scanning->add_option("--port", options->ports, "only these serial ports, instead of all");
  scanning->add_option("--modbus-tcp", options->boxes, "HOST:PORT of a gauge box to ask, too");
  scanning->add_option("--by-id", options->by_id, "folder of the ports' stable names")
      ->capture_default_str();
  scanning->add_flag("--no-search", options->no_search, "only read what the rig file names");
  scanning->callback(
      [&cli, options] { cli.action = [&cli, options] { return scan(cli, *options); }; });
}

}  // namespace sixdial::cli
